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


def loads(slip_speed):
    columns = {
        "t": T,
        "displacement": DEPTH,
        "tangential_force_x": np.full_like(T, 0.1),
        "slip": np.ones_like(T),
        "slip_speed": slip_speed,
    }
    table = predict(MODEL, columns, plain=True)
    return table["tangential_force"] / table["contact_force"] / 0.7


def test_full_sliding_is_at_the_coulomb_limit() -> None:
    assert loads(np.where(T > 0.1, 1e-3, 0.0))[-1] == pytest.approx(1.0)


def test_from_onset_on_the_share_that_slips_grows_with_the_way() -> None:
    """u_s = 0.01 x_ref = 8 um at this radius: 1 um of way more of it every 10 ms."""
    way = np.cumsum(np.where(T > 0.1, 1e-4 * 1e-2, 0.0)) / (0.01 * MODEL.reference_depth)
    told = loads(np.where(T > 0.1, 1e-4, 0.0))
    assert told == pytest.approx(1.0 - np.maximum(0.25 - way, 0.0) ** 1.5, rel=1e-4)
    assert told[0] == pytest.approx(0.875, rel=1e-4)


def test_where_it_sticks_again_nothing_is_left_of_the_way() -> None:
    assert loads(np.where((T > 0.1) & (T < 0.2), 1e-3, 0.0))[-1] == pytest.approx(0.875, rel=1e-4)
