"""A trial as one compiled call: what :mod:`.closed_loop` steps, some tens of times as fast.

The estimator's kernels, the hand and the control are one generated module, run by C where there is a C
compiler, else by numba. The input is healthy by construction, so there is no watchdog.
"""

import ctypes
import hashlib
import platform
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from vegrip import c99
from vegrip.c99 import MEMORY, REAL, host, translate
from vegrip.estimator import compiled as estimator_text
from vegrip.estimator.estimator import quantile
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import layout_of
from vegrip.grip import friction_belief
from vegrip.grip.drive_lag import measured_lag
from vegrip.grip.joint_confidence import each_confidence
from vegrip.grip.parameters import GraspParameters, models_of
from vegrip.grip.slip_table import derive_grip
from vegrip.host import compiled_folder
from vegrip.model import ContactModel
from vegrip.model import cache as model_cache
from vegrip.trials.layout import ROW_FINGER, ROW_HEAD, TrialLayout
from vegrip.trials.trial_memory import (
    burden_table,
    correlation_of,
    hand_memory,
    learning_memory,
    noise_table,
    set_control,
)
from vegrip.types import Floats
from vegrip.virtual import Disturbance, HandSettings

ENTRY = "run_whole_trial"
KINDS = (*[MEMORY] * 11, REAL, REAL, REAL)
KERNELS = ("hand", "learning", "control", "trial")
FINGERS = 5  # that the compiled trial has room for
PERIOD_S = 0.002
SAMPLING_S = 0.01

SHARED = (
    "confirmed_load", "friction_belief", "friction_probe", "friction_onset", "drive_lag", "load_lead",
    "felt_slip", "late_slip", "friction_change", "slip_trust",
)  # fmt: skip
"""Of :mod:`vegrip.grip`."""
RunTrial = Callable[..., float]


@dataclass(frozen=True)
class CompiledRun:
    """Truth of a trial; columns in the order of ``fingers``."""

    fingers: tuple[str, ...]
    slips: int
    dropped: bool
    micro_slips: int
    largest_micro_slip: float  # [m] slides of a whole patch that are too short to count as a slip
    time: Floats  # (n,) [s]
    slipped: Floats  # (n,) slips so far
    truth: dict[str, Floats]  # name in ROW_FINGER -> (n, fingers), SI
    lags: Floats  # (fingers,) [s] measured lag of each drive at the end; NaN = not known


def run_compiled(
    hand: HandSettings,
    seed: int,
    events: tuple[Disturbance, ...],
    settings: GraspParameters,
    duration: float,
    *,
    known: bool = False,
    slip_channel: str = "sound",
) -> CompiledRun:
    """Run one trial to ``duration`` [s], or until the object is lost.

    A margin grip that is ``known`` knows the truth of friction and contact instead of estimating it. A hand
    that feels slip does so by a ``slip_channel`` of SLIP_CHANNELS.
    """
    n = len(hand.fingers)
    layout = TrialLayout(n, hand.rings, hand.spokes, len(hand.tip.rates))
    models = models_of(settings, hand.fingers, "grasp_force")
    run = trial_of(models[0], layout, settings.estimator.surface == "ellipse")
    grip = derive_grip(settings.grip, n)
    settings = replace(settings, grip=grip)
    each = each_confidence(grip.probability, n, correlation_of(settings, models[0]))
    h = hand_memory(layout, hand, seed, PERIOD_S, slip_channel)
    set_control(h, layout, settings, quantile(each), quantile(grip.known_probability))
    h[layout.places()["G_KNOWN"]] = float(known)
    g, q = learning_memory(settings, models[0], n)
    tips = [initial_memory(model, layout_of(model), settings.noise, settings.estimator) for model in models]
    tips += [tips[-1]] * (FINGERS - n)
    periods = round(duration / PERIOD_S)
    rows = np.zeros((round(duration / SAMPLING_S) + 2, layout.row))
    count = run(
        *tips, h, g, q, burden_table(events, hand.step, duration),
        noise_table(hand, seed, periods, slip_channel), rows, float(periods),
        float(round(PERIOD_S / hand.step)), SAMPLING_S,
    )  # fmt: skip
    lags = np.array([measured_lag(q, i) for i in range(n)])
    return _run_of(hand.fingers, layout, h, rows[: int(count)], lags)


def _run_of(
    fingers: tuple[str, ...], layout: TrialLayout, h: Floats, rows: Floats, lags: Floats
) -> CompiledRun:
    at = layout.places()
    table = rows[:, len(ROW_HEAD) :].reshape(len(rows), len(fingers), len(ROW_FINGER))
    return CompiledRun(
        fingers,
        slips=int(h[at["H_SLIPS"]][0]),
        dropped=bool(h[at["H_DROPPED"]][0] > 0.5),
        micro_slips=int(h[at["H_MICROS"]][0]),
        largest_micro_slip=float(h[at["H_MICRO"]][0]),
        time=rows[:, 0],
        slipped=rows[:, 1],
        truth={name: table[:, :, j] for j, name in enumerate(ROW_FINGER)},
        lags=lags,
    )


def trial_of(model: ContactModel, layout: TrialLayout, ellipse: bool) -> RunTrial:
    """Return the compiled trial for estimators of ``model``; fingers with other values of it share it."""
    text = _text_of(model, layout, ellipse)
    if host.compiler() is not None:
        return _by_c(text)
    return _by_numba(text)


def _text_of(model: ContactModel, layout: TrialLayout, ellipse: bool) -> str:
    here = Path(__file__).parent / "kernels"
    grasp = Path(friction_belief.__file__)
    shared = [grasp.with_name(f"{name}.py").read_text(encoding="utf-8") for name in SHARED]
    kernels = [here.joinpath(f"{name}.py").read_text(encoding="utf-8") for name in KERNELS]
    return estimator_text.text_with(
        model, layout_of(model), [layout.constants(), *shared, *kernels], (ENTRY,), ellipse=ellipse
    )


@cache
def _by_numba(text: str) -> RunTrial:
    entry = getattr(model_cache.load(text), ENTRY)

    def run(*arguments: Floats | float) -> float:
        flat = [a.reshape(-1) if isinstance(a, np.ndarray) else a for a in arguments]
        return float(entry(*flat))

    return run


@cache
def _by_c(text: str) -> RunTrial:
    def make(library: Path) -> None:
        host.build(translate(text, {ENTRY: KINDS}).text(), library)

    function = host.load(compiled_folder.library(_name(text), make))[f"vg_{ENTRY}"]
    function.argtypes = [ctypes.c_void_p if kind == MEMORY else ctypes.c_double for kind in KINDS]
    function.restype = ctypes.c_double

    def run(*arguments: Floats | float) -> float:
        flat = [a.ctypes.data if isinstance(a, np.ndarray) else a for a in arguments]
        return float(function(*flat))

    return run


def _name(text: str) -> str:
    parts = [text, platform.machine(), str(host.compiler()), *host.FLAGS]
    parts += [path.read_text(encoding="utf-8") for path in sorted(Path(c99.__file__).parent.glob("*.py"))]
    return "vegrip_trial_" + hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]
