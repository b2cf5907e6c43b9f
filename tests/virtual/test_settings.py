"""Settings refuse what makes no hand."""

import numpy as np
import pytest

from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.virtual.settings import FingertipSettings, HandSettings, random_fingertip, vary_fingertip


def test_a_hand_is_built_from_a_table() -> None:
    table = {"fingers": ["thumb", "index"], "x": [0.0, 0.01], "y": [0.0, 0.0], "tip": {"friction": 0.5}}
    hand = build(HandSettings, table, "hand.toml")
    assert hand.fingers == ("thumb", "index")
    assert hand.tip.friction == 0.5


@pytest.mark.parametrize(
    "table",
    [
        {"fingers": ["thumb"], "x": [0.0], "y": [0.0]},
        {"fingers": ["thumb", "index"]},
        {"fingers": ["a", "a"], "x": [0.0, 0.0], "y": [0.0, 0.0]},
        {"tip": {"amplitudes": [0.6, 0.5], "rates": [1.0, 2.0]}},
        {"tip": {"amplitudes": [0.6]}},
        {"tip": {"relaxation": "power_law"}},
        {"plate": {"mass": -1.0}},
        {"rings": 1},
        {"tip": {"friction_exponent": 0.95}},
        {"tip": {"friction_exponent": -0.6}},
        {"sensor": {"tangential_gain": 0.4}},
        {"sensor": {"tangential_gain": 2.1}},
    ],
)
def test_nonsense_is_refused_in_a_sentence(table) -> None:
    with pytest.raises(ConfigError, match=r"\w+ .*\w+"):
        build(HandSettings, table, "hand.toml")


def test_random_fingertips_are_different_and_possible() -> None:
    rng = np.random.default_rng(0)
    tips = [random_fingertip(rng) for _ in range(200)]
    for name in ("radius", "reference_force", "exponent", "friction"):
        values = np.array([getattr(tip, name) for tip in tips])
        assert values.std() > 0.1 * values.mean()
    assert {len(tip.rates) for tip in tips} == {1, 2}


def test_variation_has_the_stated_spread_around_the_make() -> None:
    rng = np.random.default_rng(0)
    tip = FingertipSettings()
    friction = np.log([vary_fingertip(tip, 0.1, rng).friction / tip.friction for _ in range(3000)])
    assert friction.std() == pytest.approx(0.1, rel=0.05)
    assert vary_fingertip(tip, 0.0, rng) == tip
