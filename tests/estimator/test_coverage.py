"""The stated standard deviations are honest: a small version of ``python -m vegrip.estimator.coverage``."""

import pytest

from vegrip.estimator.coverage.table import coverage, fingertip

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("configuration", ["both", "position", "force"])
def test_intervals_cover_the_truth(configuration: str) -> None:
    """Looks at one finger are not independent, so 25 fingers leave room around 95 %."""
    found = coverage(fingertip(), configuration, truths=25, seed=7)
    for name in ("a", "k", "mu", "N", "limit_radius"):
        assert found[name].count > 300
        assert found[name].share > 0.85, (name, found[name])
