"""Short recordings of the test bench with anything hidden, as in tests/identification/fit."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from validation.diagnosis_trials.unmodelled import EVERY
from vegrip.identification.recording import Fingertip, Recording
from vegrip.virtual.bench.trial import run_trial

_spec = importlib.util.spec_from_file_location(
    "bench", Path(__file__).parents[1] / "identification" / "fit" / "conftest.py"
)
_bench = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_bench)


@pytest.fixture(scope="session")
def hide():
    """Give the recording in which effects (by name, with their parameters) are hidden."""

    def recording(seed: int = 0, **hidden: dict[str, float]) -> Recording:
        sensors = _bench.SENSORS
        trial = run_trial(
            _bench.TIP,
            _bench.PROTOCOL,
            sensors,
            seed,
            hidden=hidden,
            catalogue=EVERY,
            step=2.5e-3,
            rings=8,
            spokes=16,
            truth=False,
        )
        noise = {"normal_force": sensors.normal_force, "displacement": sensors.displacement,
                 "tangential_force": sensors.tangential_force, "torque_z": sensors.torque_z}  # fmt: skip
        columns = {k: v for k, v in trial.columns.items() if k not in ("t", "episode")}
        episode = trial.columns["episode"].astype(np.int64)
        name = "+".join(hidden) or "nothing"
        return Recording(name, trial.columns["t"], episode, columns, Fingertip(_bench.R), noise)

    return recording
