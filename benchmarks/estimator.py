"""One update of the estimator against filterpy's filters of the same size, numpy and C; five fingers at once.

8 states (indentation, speed, relaxed force, largest force, ln K, c1, zero of the displacement, bias of the
force), 2 measurements. filterpy's filters, and a filter in a dozen lines of numpy, get the same functions
written as one writes them for it, in plain Python. The C version is the very step, statement by statement,
``cc -O3 -march=native -ffp-contract=off``, in a loop inside C; it needs a C compiler and is left out where
there is none.
``five_fingers_all_outputs_vs_step`` sets what the node does with one state of each of five fingers - radius,
exponent, limit surface, margin, friction, all standard deviations and the least force, called from Python -
against one step (ratio 0.1 = ten times a step).
"""

import ctypes
import math
import tempfile
from collections.abc import Callable
from itertools import count
from pathlib import Path

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter

from benchmarks._timing import compared
from vegrip.c99 import MEMORY, REAL, host, translate
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.estimator.compiled import text_of
from vegrip.messages import NAN, FingertipState
from vegrip.model import ContactModel, paper_model
from vegrip.types import Floats

DT = 2e-3
IN_A_ROW = 1000
FORCE, DISPLACEMENT = 0.7, 8e-4  # N, m; of a hold that has relaxed, so that nothing contradicts


def run() -> dict[str, dict[str, float]]:
    model = paper_model(8e-3)
    for symbol in ("p", "nu1"):  # known: 8 states are left
        model = model.with_value(symbol, model.values[symbol].value, learn=False)
    estimator = settled(model)
    assert estimator.layout.n == 8
    module, m = estimator._module, estimator.numbers

    def step() -> None:
        module.filter_step(m, DT, FORCE, DISPLACEMENT, NAN)

    rival = Rival(model)
    found = {"estimator_step_vs_c": against_c(step, estimator)} if host.compiler() else {}
    return found | {
        "estimator_step_vs_filterpy_ukf": compared(step, rival.unscented(estimator)),
        "estimator_step_vs_filterpy_ekf": compared(step, rival.extended(estimator)),
        "estimator_step_vs_numpy": compared(step, rival.in_numpy(estimator)),
        "five_fingers_all_outputs_vs_step": compared(hand_of(5, model), step),
    }


def hand_of(fingers: int, model: ContactModel) -> Callable[[], object]:
    """Give the call that takes a state of each finger through its estimator and asks for the least force."""
    estimators = [settled(model) for _ in range(fingers)]
    stamps = count(round(3000 * DT * 1e9), round(DT * 1e9))

    def states() -> None:
        stamp = next(stamps)
        for estimator in estimators:
            state = FingertipState(stamp, "tip", stamp, FORCE, 0.2, 0.0, 1e-4, DISPLACEMENT, NAN, 0.0)
            estimator.assimilate(state)
            estimator.least_force(0.3)

    return states


def settled(model: ContactModel) -> ContactEstimator:
    """Give an estimator in the middle of a hold."""
    estimator = ContactEstimator(model, SensorNoise())
    t = np.arange(3000) * DT
    depth = np.interp(t, [0.2, 0.6], [-1e-4, DISPLACEMENT])
    force = model.simulate(t, depth).normal_force
    for i in range(t.size):
        estimator.update(FingertipState(int(t[i] * 1e9), "tip", i, force[i], 0.2, 0.0, 1e-4, depth[i]))
    return estimator


LOOP = """
void many(int32_t count, double *m, double dt, double force, double displacement, double radius)
{
    for (int32_t i = 0; i < count; i++) {
        vg_filter_step(m, dt, force, displacement, radius);
    }
}
"""
AS_FAST_AS_CAN_BE = (*host.FLAGS, "-O3", "-march=native")


def against_c(step: Callable[[], object], estimator: ContactEstimator) -> dict[str, float]:
    """Compare a step called from Python with one in a loop of ``IN_A_ROW`` in C."""
    program = translate(text_of(estimator.model, estimator.layout), {"filter_step": (MEMORY, *[REAL] * 4)})
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "step.so"
        host.build(program.text() + LOOP, library, AS_FAST_AS_CAN_BE)
        many = host.load(library).many
    many.argtypes = [ctypes.c_int32, ctypes.c_void_p, *[ctypes.c_double] * 4]
    many.restype = None
    m = estimator.numbers.copy()
    figures = compared(step, lambda: many(IN_A_ROW, m.ctypes.data, DT, FORCE, DISPLACEMENT, NAN))
    theirs = figures["theirs_us"] / IN_A_ROW
    return {"ours_us": figures["ours_us"], "theirs_us": theirs, "ratio": theirs / figures["ours_us"]}


class Rival:
    """The same model for filterpy: state in, state out."""

    def __init__(self, model: ContactModel) -> None:
        self.x_ref, self.p = model.reference_depth, model.values["p"].value
        self.nu = model.values["nu1"].value

    def elastic(self, depth: float, ln_K: float) -> float:
        return math.exp(ln_K) * (depth / self.x_ref) ** self.p if depth > 0.0 else 0.0

    def f(self, x: Floats, dt: float) -> Floats:
        delta, speed, z, largest, ln_K, c, d0, bF = x
        before = max(self.elastic(delta, ln_K), c * z)
        delta += speed * dt
        after = self.elastic(delta, ln_K)
        h = self.nu * dt
        lost = -math.expm1(-h)
        phi = lost / h
        kept = z + lost * (before - z) - (1.0 - phi) * before
        z = kept + (1.0 - phi) * after
        if after - c * z < 0.0:  # the free surface
            z = kept / (1.0 - c * (1.0 - phi))
        force = max(after - c * z, 0.0)
        return np.array([delta, speed, z, max(force, largest) if force > 0.0 else 0.0, ln_K, c, d0, bF])

    def h(self, x: Floats) -> Floats:
        delta, _, z, _, ln_K, c, d0, bF = x
        return np.array([delta + d0, max(self.elastic(delta, ln_K) - c * z, 0.0) + bF])

    def noise(self) -> tuple[Floats, Floats]:
        q = np.array([1e-15, 3e-6, 0.0, 0.0, 2e-9, 2e-10, 2e-14, 5e-8])
        return np.diag(q + 1e-18), np.diag([25e-12, 1e-4])

    def unscented(self, estimator: ContactEstimator) -> Callable[[], object]:
        points = MerweScaledSigmaPoints(8, alpha=0.5, beta=2.0, kappa=-5.0)
        ukf = UnscentedKalmanFilter(8, 2, DT, hx=self.h, fx=self.f, points=points)
        ukf.x, ukf.P = start(estimator)
        ukf.Q, ukf.R = self.noise()

        def step() -> None:
            ukf.predict()
            ukf.update(np.array([DISPLACEMENT, FORCE]))

        return step

    def extended(self, estimator: ContactEstimator) -> Callable[[], object]:
        ekf = ExtendedKalmanFilter(8, 2)
        x, ekf.P = start(estimator)
        ekf.x = x.reshape(8, 1)
        ekf.Q, ekf.R = self.noise()

        def step() -> None:
            x = ekf.x.ravel()
            ekf.F = jacobian(lambda s: self.f(s, DT), x)
            ekf.x = self.f(x, DT).reshape(8, 1)
            ekf.P = ekf.F @ ekf.P @ ekf.F.T + ekf.Q
            z = np.array([[DISPLACEMENT], [FORCE]])
            ekf.update(z, lambda s: jacobian(self.h, s.ravel()), lambda s: self.h(s.ravel()).reshape(2, 1))

        return step

    def in_numpy(self, estimator: ContactEstimator) -> Callable[[], object]:
        x, P = start(estimator)
        Q, R = self.noise()
        z = np.array([DISPLACEMENT, FORCE])
        state = [x, P]

        def step() -> None:
            x, P = state
            F = jacobian(lambda s: self.f(s, DT), x)
            x, P = self.f(x, DT), F @ P @ F.T + Q
            H = jacobian(self.h, x)
            K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
            left = np.eye(8) - K @ H
            state[:] = x + K @ (z - self.h(x)), left @ P @ left.T + K @ R @ K.T

        return step


def jacobian(of: Callable[[Floats], Floats], x: Floats) -> Floats:
    """Forward differences, as one writes them when the model has no derivatives."""
    base = of(x)
    columns = []
    for j in range(8):
        h = 1e-6 * max(abs(x[j]), 1e-6)
        moved = x.copy()
        moved[j] += h
        columns.append((of(moved) - base) / h)
    return np.array(columns).T


def start(estimator: ContactEstimator) -> tuple[Floats, Floats]:
    """State and covariance of the same moment, made safely positive for filterpy's Cholesky root."""
    P = estimator.covariance
    scale = np.maximum(np.diag(P), np.array([1e-12, 1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-13, 1e-7]))
    return estimator.numbers[: estimator.layout.n].copy(), np.diag(scale)
