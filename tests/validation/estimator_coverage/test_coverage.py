"""The stated standard deviations are honest: a small ``python -m validation.estimator_coverage``."""

import math

import pytest

from validation.estimator_coverage.table import coverage, fingertip

pytestmark = pytest.mark.long

FINGERS = 25
LEAST = 0.95 - 3.0 * math.sqrt(0.95 * 0.05 / FINGERS)
"""All looks at one finger may share one error (its zero), so only the fingers count as independent."""


@pytest.mark.parametrize("configuration", ["position", "force"])
def test_intervals_cover_the_truth(configuration: str) -> None:
    found = coverage(fingertip(), configuration, truths=FINGERS, seed=7)
    for name in ("a", "k", "mu", "N", "limit_radius"):
        assert found[name].count > 300
        assert found[name].share > LEAST, (name, found[name])
