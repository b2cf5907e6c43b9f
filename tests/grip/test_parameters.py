"""What of a finger's settings follows from others, and what a file may not set."""

import pytest

from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.estimator import EstimatorSettings
from vegrip.grip.parameters import GraspParameters, estimator_factory


def estimator_of(table: dict[str, object]) -> EstimatorSettings:
    parameters = build(GraspParameters, table, "hand.toml")
    return estimator_factory(parameters, ("index",), "hand.toml")("index").settings


@pytest.mark.parametrize(
    ("time_out", "gap", "memory"), [(0.05, 0.25, 2.0), (0.03, 0.25, 2.0), (0.1, 0.25, 4.0), (0.5, 0.5, 20.0)]
)
def test_an_estimate_at_a_low_rate_bears_longer_gaps_and_is_judged_by_as_many_samples(
    time_out: float, gap: float, memory: float
) -> None:
    settings = estimator_of({"watchdog": {"time_out": time_out}})
    assert (settings.longest_gap, settings.health_time) == (gap, pytest.approx(memory))


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"limits": {"lower_rate": 8.0}}, "lower_rate"),
        ({"fail_safe": {"hold_time": 0.25}}, "hold_time"),
        ({"tip": {"friction": 0.5}}, "friction"),
        ({"tips": {"index": {"friction": 0.5}}}, "friction"),
        ({"estimator": {"horizon": 1.0}}, "horizon"),
    ],
)
def test_a_file_that_sets_a_constant_is_refused_in_one_sentence(table: dict[str, object], key: str) -> None:
    with pytest.raises(ConfigError, match=f"'{key}' is a constant and no parameter; leave it out$"):
        estimator_of(table)
