"""The effect holds to the laws of every effect, and to one of its own."""

import numpy as np
from vegrip_second_spot import EFFECT

from vegrip.model import paper_model
from vegrip.model.laws import broken_laws


def test_no_law_is_broken():
    assert broken_laws(EFFECT) == []


def test_above_the_second_spot_nothing_changes():
    base = paper_model(8e-3)
    model = base.with_effect(EFFECT)
    t = np.linspace(0.0, 1.0, 200)
    depth = 1.1 * base.reference_depth * t
    np.testing.assert_array_equal(model.simulate(t, depth).normal_force, base.simulate(t, depth).normal_force)
