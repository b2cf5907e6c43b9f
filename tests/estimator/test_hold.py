"""The three holds against an independent long simulation: the drive's equation solved as an ODE by scipy."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vegrip.contact.limit_surface.fast import gauges
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB
from vegrip.messages import ContactEstimate, FingertipState
from vegrip.model import ContactModel, Simulation
from vegrip.types import Floats

Record = Callable[..., list[FingertipState]]
Run = Callable[[ContactEstimator, list[FingertipState]], ContactEstimate]
KNOTS, DEPTHS = [0.0, 0.3, 0.5, 0.6], [-1e-4, -1e-4, 9e-4, 9e-4]
QUIET = SensorNoise(1e-5, 1e-8, 1e-9, 1e-12)
LATER = np.geomspace(1e-4, 60.0, 4000)  # [s]
SPREAD = 0.3  # relative std of the share that is still to relax
QUANTILE = 1.6448536269514722  # of 95 %
FRICTION = 0.1
"""Std of ln mu."""
SCATTER = EstimatorSettings().friction_scatter
ONSET = math.hypot(0.1, SCATTER)
"""Relative std of the utilisation at which the next slip begins."""


@pytest.fixture
def known(model: ContactModel) -> ContactModel:
    """A fingertip of which everything is known but friction, and that to 10 %."""
    for symbol in model.values:
        model = model.with_value(symbol, model.values[symbol].value, std=0.1 if symbol == "mu" else 1e-6)
    return model


def holding(
    model: ContactModel, hold: str, stiffness: float = 1000.0, horizon: float = 1.0
) -> ContactEstimator:
    settings = EstimatorSettings(
        friction=COULOMB, hold=hold, hold_stiffness=stiffness, horizon=horizon, offset=1e-6, force_bias=1e-3
    )
    return ContactEstimator(model, QUIET, settings)


def held(model: ContactModel) -> tuple[Floats, Simulation]:
    """The press before the hold, simulated."""
    t = np.linspace(0.0, KNOTS[-1], 601)
    return t, model.simulate(t, np.interp(t, KNOTS, DEPTHS))


def loaded(estimator: ContactEstimator, press: Record, run: Run, force: float, torque: float = 0.0) -> None:
    """Lead the estimator into the hold, put its contact where the simulation's is, and load it.

    Here the forecast is tested, not the filter, which takes the largest force a little too large.
    """
    model = estimator.model
    states = press(model, KNOTS, DEPTHS, noise=QUIET)
    without = {"tangential_force_x": 0.0, "tangential_force_y": 0.0, "torque_z": 0.0}
    run(estimator, [dataclasses.replace(s, **without) for s in states])
    load = {"tangential_force_x": force, "torque_z": torque, "slip": math.nan}
    estimator.update(dataclasses.replace(states[-1], stamp=states[-1].stamp + 1, **load))
    _, contact = held(model)
    z = contact.elastic_force[-1] - contact.normal_force[-1]
    at = 2 + model.plan.states.index("z1")
    estimator.numbers[:2] = DEPTHS[-1], 0.0
    estimator.numbers[at] = z
    estimator.numbers[2 + model.plan.states.index("largest_force")] = contact.normal_force.max()


def simulated(model: ContactModel, stiffness: float) -> Simulation:
    """Hold from the end of the record on; ``z' = nu (N_e - z)`` with ``N_e - c z + k_d delta`` constant."""
    K, p, c, nu = (model.values[symbol].value for symbol in ("K", "p", "c1", "nu1"))
    x_ref = model.reference_depth
    t, before = held(model)
    delta0, N0, e0 = DEPTHS[-1], before.normal_force[-1], before.elastic_force[-1]

    def depth(z: float) -> float:
        def left(d: float) -> float:
            return float(K * (d / x_ref) ** p - c * z - N0 + stiffness * (d - delta0))

        return float(brentq(left, 0.5 * delta0, 4.0 * delta0, xtol=1e-15)) if stiffness < 1e8 else delta0

    def rate(_: float, z: Floats) -> list[float]:
        return [nu * (K * (depth(z[0]) / x_ref) ** p - z[0])]

    z = solve_ivp(rate, (0.0, LATER[-1]), [(e0 - N0) / c], t_eval=LATER, rtol=1e-9, atol=1e-12).y[0]
    path = [depth(value) for value in z]
    whole = model.simulate(np.r_[t, t[-1] + LATER], np.r_[np.interp(t, KNOTS, DEPTHS), path])
    return Simulation(*(column[t.size :] for column in whole))


def utilisation(contact: Simulation, force: float, torque: float) -> Floats:
    limit = contact.friction_coefficient * contact.normal_force
    found: Floats = gauges(
        contact.pressure_exponent, force / limit, torque / (limit * contact.contact_radius)
    )
    return found


def first(over: NDArray[np.bool_]) -> float:
    return float(LATER[np.flatnonzero(over)[0]]) if over.any() else math.inf


@pytest.mark.parametrize(
    ("hold", "stiffness"), [("position", math.inf), ("mixed", 3000.0), ("mixed", 500.0), ("mixed", 50.0)]
)
@pytest.mark.parametrize("twist", [0.0, 0.5, 1.0])
def test_time_to_slip_and_its_bound_agree_with_simulating_the_hold(
    known: ContactModel, press: Record, run: Run, hold: str, stiffness: float, twist: float
) -> None:
    future = simulated(known, stiffness)
    N, a = future.normal_force, future.contact_radius[0]
    load = np.array([math.cos(twist), a * math.sin(twist)])
    relative = np.hypot(ONSET, SPREAD * np.log(N[0] / N))
    used = utilisation(future, *load)
    bound = used * np.exp(QUANTILE * relative)
    for course in (used, bound):
        if course.argmax() == 0:  # creep outweighs relaxation: it gets only better
            continue
        at = int(np.argmin(np.abs(course - 0.5 * (course[0] + course.max()))))
        estimator = holding(known, hold, min(stiffness, 1e9))
        loaded(estimator, press, run, *(load / course[at]))
        margin = estimator.slip_margin()
        found = margin.time_to_slip if course is used else margin.earliest_slip
        assert found == pytest.approx(LATER[at], rel=0.01)


@pytest.mark.parametrize("share", [0.9, 1.0, 1.15])
def test_a_contact_that_has_held_its_load_slips_by_the_conditional_law(
    known: ContactModel, press: Record, run: Run, share: float
) -> None:
    """Half of the grips that have held ``share`` of what they are believed to carry slip by the estimate."""
    future = simulated(known, math.inf)
    N, load = future.normal_force, share * known.values["mu"].value * future.normal_force[0]
    estimator = holding(known, "position")
    loaded(estimator, press, run, load)
    m = estimator.numbers
    m[dict(estimator.layout.named_places())["FRI_PEAK"]] = load / N[0]
    margin = estimator.slip_margin()
    rng = np.random.default_rng(0)
    onset = np.log(known.values["mu"].value) + ONSET * rng.standard_normal(400_000)
    survivors = onset[onset > math.log(load / N[0])]
    lost = np.log(N[0] / N)
    errors = SPREAD * rng.standard_normal(survivors.size)
    # slip where ln(load/N) + error * lost exceeds the onset; the error may not raise the load that was held
    slip_at = np.array(
        [np.mean((1.0 + errors) * part > survivors - math.log(load / N[0])) for part in lost[::40]]
    )
    for chance, found in ((0.5, margin.time_to_slip), (0.05, margin.earliest_slip)):
        if slip_at[-1] < chance:
            assert found == math.inf
        else:
            at = np.interp(chance, slip_at, lost[::40])
            assert np.interp(found, LATER, lost) == pytest.approx(at, rel=0.03)


def test_a_held_force_never_gets_worse(known: ContactModel, press: Record, run: Run) -> None:
    future = simulated(known, 0.0)
    for force, torque in ((0.5, 0.0), (0.4, 1e-3), (0.0, 2e-3)):
        used = utilisation(future, force, torque)
        assert used.max() <= used[0] * (1.0 + 1e-6)
    estimator = holding(known, "force")
    loaded(estimator, press, run, 0.95 * known.values["mu"].value * future.normal_force[0])
    assert estimator.slip_margin().time_to_slip == math.inf


def test_a_mixed_hold_lies_between_its_limits(known: ContactModel, press: Record, run: Run) -> None:
    def asked(hold: str, stiffness: float = 1.0) -> tuple[float, float, float]:
        estimator = holding(known, hold, stiffness)
        loaded(estimator, press, run, 0.5)
        margin = estimator.slip_margin()
        return estimator.least_force(0.1), margin.time_to_slip, margin.earliest_slip

    position, force = asked("position"), asked("force")
    assert position[1] < math.inf
    assert asked("mixed", 1e9) == pytest.approx(position, rel=1e-4)
    assert asked("mixed", 1e-6) == pytest.approx(force, rel=1e-4)
    mixed = [asked("mixed", k) for k in (1e1, 1e2, 1e3, 1e4)]
    forces, times = [f for f, _, _ in mixed], [t for _, t, _ in mixed]
    assert force[0] < forces[0]
    assert forces == sorted(forces)
    assert forces[-1] < position[0]
    assert times == sorted(times, reverse=True)
    assert times[-1] > position[1]


@pytest.mark.parametrize("stiffness", [100.0, 1000.0])
def test_the_least_force_of_a_mixed_hold_just_keeps_the_margin_to_the_horizon(
    known: ContactModel, press: Record, run: Run, stiffness: float
) -> None:
    """The jump of the fingertip to the least force, then the hold, simulated."""
    estimator = holding(known, "mixed", stiffness, horizon=2.0)
    load, margin = 0.5, 0.2
    loaded(estimator, press, run, load)
    least = estimator.least_force(margin)
    K, p, c, nu, mu = (known.values[symbol].value for symbol in ("K", "p", "c1", "nu1", "mu"))
    contact, x_ref = held(known)[1], known.reference_depth
    z0 = (contact.elastic_force[-1] - contact.normal_force[-1]) / c
    origin = x_ref * ((least + c * z0) / K) ** (1.0 / p)

    def elastic(z: float) -> float:
        def left(d: float) -> float:
            return float(K * (d / x_ref) ** p - c * z - least + stiffness * (d - origin))

        return float(K * (brentq(left, 1e-5, 4e-3, xtol=1e-15) / x_ref) ** p)

    held_on = solve_ivp(lambda _, z: [nu * (elastic(z[0]) - z[0])], (0.0, 2.0), [z0], rtol=1e-9, atol=1e-12)
    later = held_on.y[0, -1]
    N = elastic(later) - c * later
    bound = load / (mu * N) * math.exp(QUANTILE * math.hypot(FRICTION, SPREAD * math.log(least / N)))
    assert bound == pytest.approx(1.0 - margin, rel=2e-3)
