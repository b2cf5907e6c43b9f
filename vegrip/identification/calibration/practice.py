"""A fingertip to practise on: the virtual bench, which shares no physics with the models, does each trial."""

import numpy as np

from vegrip.identification.calibration.trials import Trial
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings, random_fingertip

PRACTICE_RATE_HZ = 200.0  # [Hz]


def practice_tip(seed: int) -> FingertipSettings:
    """Return a fingertip as different from others as soft fingertips are."""
    return random_fingertip(np.random.default_rng(seed))


def true_values(tip: FingertipSettings) -> dict[str, float]:
    """Return what a calibration of ``tip`` should find: K at a tenth of the radius, p and mu."""
    deeper = 0.1 * tip.radius / tip.reference_indentation
    return {"K": tip.reference_force * deeper**tip.exponent, "p": tip.exponent, "mu": tip.friction}


def practise(trial: Trial, tip: FingertipSettings, seed: int = 0) -> Recording:
    """Return what sensors measure of ``tip`` in ``trial``."""
    sensors = SensorSettings(rate=PRACTICE_RATE_HZ)
    episodes, pause = trial.protocol.episodes, trial.protocol.pause
    made = run_trial(tip, episodes, sensors, seed, pause=pause, rings=8, spokes=16, truth=False)
    columns = {name: values for name, values in made.columns.items() if name in CHANNELS}
    noise = {
        name: getattr(sensors, name)
        for name in ("normal_force", "displacement", "tangential_force", "torque_z", "slip_speed")
    }
    source: dict[str, str | int | float | bool] = {"made_by": "vegrip calibrate --virtual", "seed": seed}
    return Recording(
        trial.protocol.name,
        made.columns["t"],
        made.columns["episode"].astype(np.int64),
        columns,
        Fingertip(tip.radius),
        noise,
        source,
    )
