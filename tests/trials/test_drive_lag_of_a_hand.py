"""The lag that the control measures while it grips is the one of the simulated drives."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.trials.fronts import QualityTrial, Surroundings, record_trial


@pytest.mark.long
@pytest.mark.parametrize("bandwidth", [5.0, 80.0])
def test_the_lag_of_the_drives_is_found_within_a_fifth_in_a_few_grasps(bandwidth: float) -> None:
    trial = QualityTrial("learning", 200, 10.0, 0.1, "pinch", Surroundings(bandwidth))
    lags = np.concatenate([record_trial(replace(trial, seed=seed)).lags for seed in range(200, 208)])
    period = 0.002
    truth = period / (1.0 - math.exp(-period * 2.0 * math.pi * bandwidth))
    assert len(lags) >= 6
    assert np.median(lags) == pytest.approx(truth, rel=0.2)
