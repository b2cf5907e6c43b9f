"""Without a displacement: how the indentation goes with a parameter at constant force."""

import numpy as np
import pytest
from scipy.optimize import brentq

from vegrip.estimator.compiled import module_for
from vegrip.estimator.estimator import LOST, ContactEstimator
from vegrip.estimator.layout import layout_of
from vegrip.estimator.settings import SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model

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


@pytest.mark.parametrize("jump", [0.0, 3.0])
def test_a_force_that_presses_a_tip_by_more_than_its_radius_is_followed(jump) -> None:
    estimator = ContactEstimator(paper_model(9e-3), SensorNoise())
    noise = 0.01 * np.random.default_rng(1).standard_normal((600, 3))
    for k in range(600):
        t = 5e-3 * k
        force = 16.0 * min(t / 0.5, 1.0)
        if t > 0.75:
            force = min(16.0 + jump + 80.0 * (t - 0.75), 28.8)
        state = FingertipState(
            (k + 1) * 5_000_000, "index", k, normal_force=force + noise[k, 0],
            tangential_force_x=noise[k, 1], tangential_force_y=noise[k, 2],
        )  # fmt: skip
        estimator.assimilate(state)
    assert estimator.normal_force.value == pytest.approx(28.8, abs=0.05)
    assert estimator.health().regime != LOST
