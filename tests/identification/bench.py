"""Small recordings of the test bench, which shares no physics with the model; an effect may be hidden."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from vegrip.identification.recording import Fingertip, Recording
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Episode, Segment, creep, hold, sine, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings

R = 0.01
TIP = FingertipSettings(
    radius=R, reference_force=1.8, amplitudes=(0.3,), rates=(3.1,), friction=0.8, bristle_stiffness=1e10
)
SENSORS = SensorSettings(rate=200.0, force_step=0.0, displacement_step=0.0, torque_step=0.0)
MEASURED = ("normal_force", "displacement", "tangential_force", "torque_z")
NOISE = {name: getattr(SENSORS, name) for name in MEASURED}
CLEAR = Segment(0.2, depth=-2e-4)
PROTOCOL = tuple(
    (CLEAR, *episode[1:], CLEAR)
    for episode in (
        hold(5e-4, 1.5),
        hold(1e-3, 1.5),
        hold(1.6e-3, 1.5),
        creep(1.0, 1.5),
        triangles(1.3e-3, 1e-3, 1),
        triangles(1.3e-3, 8e-3, 1),
        sine(1e-3, 3e-4, 4.0, 8),
        slip(0.7, 0.3, pull=2e-3, duration=0.5),
        slip(1.8, 0.3, pull=2e-3, duration=0.5),
        slip(1.4, 1.5, pull=2e-3, duration=0.5),
        slip(1.2, 0.3, spin=0.8, duration=0.5),
        slip(1.8, 1.0, spin=0.8, duration=0.5),
    )
)
assert AIR_SEGMENT in hold(1e-3, 1.0)


def recorded(
    name: str,
    seed: int,
    hidden: Mapping[str, Mapping[str, float]],
    protocol: Sequence[Episode] = PROTOCOL,
    tip: FingertipSettings = TIP,
    **how: Any,
) -> Recording:
    """Return the recording of the bench in which effects (by name, with their parameters) are hidden."""
    trial = run_trial(
        tip, protocol, SENSORS, seed, hidden=hidden, step=2.5e-3, rings=8, spokes=16, truth=False, **how
    )
    columns = {k: v for k, v in trial.columns.items() if k not in ("t", "episode")}
    episode = trial.columns["episode"].astype(np.int64)
    return Recording(name, trial.columns["t"], episode, columns, Fingertip(R), NOISE)


HIDDEN = {
    "adhesion": {"force": 0.05},
    "second_relaxation": {"amplitude": 0.1},
    "sensor_lag": {"time": 5e-3},
    "load_dependent_friction": {"exponent": 0.2},
    "exponential_stiffness": {"length": 1.5e-3},
}


@cache
def bench_recording(name: str = "", amount: float = 1.0, seed: int = 0) -> Recording:
    hidden = {name: {key: value * amount for key, value in HIDDEN[name].items()}} if name else {}
    return recorded(name or "plain", seed, hidden)
