"""What is accepted holds its place against whatever resembles it, on a fingertip of a few lines."""

import pytest

from vegrip.identification.diagnosis import diagnose

pytestmark = pytest.mark.slow
KINDS = ("hold", "ramp", "hold", "ramp", "hold", "ramp")


@pytest.mark.parametrize(
    ("seed", "second", "pull", "verdict"),
    [
        (4, (0.134, 5.87), 0.029, "named"),
        (12, (0.062, 13.14), 0.052, "ambiguous"),  # with a power law, by one percent of the gain
    ],
)
def test_a_second_relaxation_beside_adhesion_is_not_called_a_power_law(
    tip, seed, second, pull, verdict
) -> None:
    """Where the power law came first, it was kept although the second time explains more beside adhesion."""
    found = diagnose(tip(seed, kinds=KINDS, branches=((0.3, 3.0), second), pull=pull))
    assert found.verdict == verdict
    sets = found.indistinguishable or [[name] for name in found.named]
    assert any("second_relaxation" in one for one in sets)
