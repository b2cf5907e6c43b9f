"""Small recordings of the test bench, which shares no physics with the model."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from vegrip.identification.recording import Fingertip, Recording
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Segment, creep, hold, sine, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings

R = 0.01
TIP = FingertipSettings(
    radius=R, reference_force=1.8, amplitudes=(0.3,), rates=(3.1,), friction=0.8, bristle_stiffness=1e10
)
SENSORS = SensorSettings(rate=200.0, force_step=0.0, displacement_step=0.0, torque_step=0.0)
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


@cache
def bench_recording(name: str = "", amount: float = 1.0, seed: int = 0) -> Recording:
    hidden = {name: {key: value * amount for key, value in HIDDEN[name].items()}} if name else None
    trial = run_trial(TIP, PROTOCOL, SENSORS, seed, hidden=hidden, rings=8, spokes=16)
    noise = {"normal_force": SENSORS.normal_force, "displacement": SENSORS.displacement,
             "tangential_force": SENSORS.tangential_force, "torque_z": SENSORS.torque_z}  # fmt: skip
    columns = {k: v for k, v in trial.columns.items() if k not in ("t", "episode")}
    return Recording(
        name or "plain", trial.columns["t"], trial.columns["episode"].astype(np.int64), columns,
        Fingertip(R), noise,
    )  # fmt: skip


HIDDEN = {
    "adhesion": {"force": 0.05},
    "second_relaxation": {"amplitude": 0.1},
    "sensor_lag": {"time": 5e-3},
    "load_dependent_friction": {"exponent": 0.2},
    "exponential_stiffness": {"length": 1.5e-3},
}


@pytest.fixture(scope="session")
def bench() -> Callable[..., Recording]:
    """Give the recording with a hidden effect (by name, amount, seed), or with none."""
    return bench_recording
