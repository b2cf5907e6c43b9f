"""What a step tells beside the state."""

import math

import numpy as np
import pytest
from scipy.stats import norm


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.975])
def test_a_margin_is_told_at_the_stated_confidence(kernels, m, monkeypatch, confidence) -> None:
    asked = []
    monkeypatch.setattr(kernels, "slip_times", lambda _, *given: (asked.append(given), (3.0, 1.5))[1])
    kernels.report(m, 0.3, 5e-4)
    m[kernels.SET_QUANTILE] = norm.ppf(confidence)
    out = np.zeros(5)
    kernels.margin_of(m, 0.3, 5e-4, out)
    gauge = m[kernels.REP_GAUGE]
    upper = kernels.upper_gauge(
        gauge, m[kernels.REP_GAUGE_REL], m[kernels.REP_GAUGE_ABS], norm.ppf(confidence)
    )
    assert out[0] == gauge
    assert out[1] == upper
    assert out[2] == kernels.force_reserve(m, 0.3, 5e-4)
    assert out[3:].tolist() == [3.0, 1.5]
    ((tangential, torque, chance),) = asked
    assert (tangential, torque) == (0.3, 5e-4)
    assert chance == pytest.approx(1.0 - confidence)


@pytest.mark.parametrize("value", [1.0, -3e4, 0.0])
def test_a_value_that_a_sensor_may_measure_is_kept(kernels, value) -> None:
    assert kernels.plausible_value(value) == value
    for beyond in (math.nan, math.inf, -math.inf, 1e200, -1e200):
        assert math.isnan(kernels.plausible_value(beyond))
