"""Without a displacement: how the indentation goes with a parameter at constant force."""

import pytest
from scipy.optimize import brentq

from vegrip.estimator.compiled import module_for
from vegrip.estimator.layout import layout_of

DIFFERENCE = 1e-3  # of the coordinates of the parameters, each way


def test_the_slope_at_constant_force_is_that_of_the_indentation_that_gives_this_force(
    model, estimator, press
) -> None:
    for state in press(model, [0.0, 0.2, 0.4, 1.0], [-2e-4, -2e-4, 8e-4, 8e-4]):
        estimator.assimilate(state)
    law = module_for(model, layout_of(model), plain=True)
    m, y = estimator.memory, law.Y0
    held, depth = law.contact(m, y)[2], m[y + law.DELTA]
    assert held > 0.1

    def depth_for(place: int, value: float) -> float:
        """Solve the force for the indentation, with one parameter at ``value``."""
        keep, m[place] = m[place], value

        def beyond(delta: float) -> float:
            m[y + law.DELTA] = delta
            return law.contact(m, y)[2] - held

        found = brentq(beyond, 0.5 * depth, 1.5 * depth, xtol=1e-15)
        m[place], m[y + law.DELTA] = keep, depth
        return found

    slopes = []
    for j in range(law.LEARNED_FROM, law.M):
        above, below = (depth_for(y + j, m[y + j] + step) for step in (DIFFERENCE, -DIFFERENCE))
        slopes.append((above - below) / (2.0 * DIFFERENCE))
        assert law.slope_at_constant_force(m, y, j) == pytest.approx(slopes[-1], rel=0.01, abs=1e-9)
    assert min(slopes) < -1e-4  # a stiffer tip is pressed in less
