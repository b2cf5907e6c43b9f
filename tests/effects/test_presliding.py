"""Presliding: slip is felt before the whole contact slides."""

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict

T = np.arange(0.0, 0.3, 1e-2)
DEPTH = np.full_like(T, 1e-3)
MODEL = paper_model(0.01).with_effect(effect("presliding")).with_value("A_s", 0.75)


def test_hertzian_onset_is_that_of_cattaneo_and_mindlin() -> None:
    """Half of the radius sticks: f / (mu N) = 1 - (1/2)^3."""
    mu = MODEL.simulate(T, DEPTH, plain=True).friction_coefficient
    assert mu / 0.7 == pytest.approx(np.full_like(T, 1.0 - 0.5**3), rel=1e-4)


@pytest.mark.parametrize("p", [1.2, 2.0])
def test_onset_follows_the_force_law_of_the_contact(p) -> None:
    """f = mu (N - N(c)), the load that the part that sticks would carry by itself: x ~ c^2."""
    model = MODEL.with_value("p", p)
    mu = model.simulate(T, DEPTH, plain=True).friction_coefficient[-1]
    whole, inner = (model.simulate(T, s * DEPTH, plain=True).elastic_force[-1] for s in (1.0, 0.25))
    assert mu / 0.7 == pytest.approx((whole - inner) / whole, rel=1e-4)


def test_full_sliding_is_at_the_coulomb_limit() -> None:
    columns = {
        "t": T,
        "displacement": DEPTH,
        "tangential_force_x": np.full_like(T, 0.1),
        "slip_speed": 0.0 * T,
    }
    onset, sliding = (
        predict(
            MODEL, {**columns, "slip": np.full_like(T, slip), "slip_speed": slip * 1e-3 + 0.0 * T}, plain=True
        )
        for slip in (0.0, 1.0)
    )
    assert sliding["tangential_force"] == pytest.approx(0.7 * sliding["contact_force"])
    assert onset["tangential_force"] == pytest.approx(0.875 * sliding["tangential_force"], rel=1e-4)
