"""Adhesion against the closed forms of slow taps."""

import numpy as np
import pytest

DEPTH = 0.0008


@pytest.fixture
def model(model_with):
    return model_with("adhesion").with_value("g_v", 0.0).with_value("c1", 0.0)


def work_of_adhesion(model):
    """W [J/m^2], as the effect's text gives it."""
    return model.values["pull"].value * model.values["K"].value / (2.0 * np.pi * model.tip_radius)


def test_the_pull_off_force_is_that_of_derjaguin_muller_and_toporov(model):
    """``2 pi R W``, the least force of a tap; and an elastic contact shows it at x = 0."""
    delta = DEPTH * np.concatenate([np.linspace(-0.5, 1.0, 151), np.linspace(1.0, -0.5, 151)])
    force = model.simulate(np.arange(delta.size), delta).sensed_force
    assert force.min() == pytest.approx(-2.0 * np.pi * model.tip_radius * work_of_adhesion(model), rel=1e-12)
    assert delta[np.argmin(force)] == pytest.approx(0.0, abs=1e-12 + 0.01 * DEPTH)


def test_it_pulls_on_the_way_out_of_where_it_did_not_on_the_way_in(model):
    """Above the surface: nothing on approach, a stretching neck on retraction, nothing once it has parted."""
    delta = DEPTH * np.array([-0.1, 0.5, -0.1, -0.19, -0.21, -0.1])
    force = model.simulate(np.arange(6.0), delta).sensed_force
    full = model.values["pull"].value * model.values["K"].value
    neck = model.values["neck"].value
    assert force[0] == 0.0
    np.testing.assert_allclose(force[2:4], -full * (1.0 - np.array([0.1, 0.19]) / neck) ** 2, rtol=1e-9)
    np.testing.assert_array_equal(force[4:], 0.0)


def test_contact_shifts_the_force_by_the_pull(model, model_with):
    plain = model_with("relaxation").with_value("c1", 0.0)
    delta = DEPTH * np.linspace(0.1, 2.0, 20)
    shift = (
        model.simulate(np.arange(20.0), delta).sensed_force
        - plain.simulate(np.arange(20.0), delta).sensed_force
    )
    np.testing.assert_allclose(shift, -model.values["pull"].value * model.values["K"].value, rtol=1e-9)


def test_faster_separation_takes_more_work_by_a_power_of_the_speed(model):
    """``W / W_0 - 1 ~ v^n``: a hundred times the speed, ten times the growth with n = 1/2."""
    model = model.with_value("g_v", 0.3)
    full = model.values["pull"].value * model.values["K"].value
    growth = []
    for speed in (0.01, 1.0):
        t = np.array([0.0, 1.0, 1.0 + 0.5 / speed])
        force = model.simulate(t, DEPTH * np.array([0.0, 0.5, 0.0])).sensed_force
        growth.append(-force[-1] / full - 1.0)
    assert growth == pytest.approx([0.03, 0.3], rel=1e-9)


def test_a_relaxed_contact_sticks_after_its_surface_has_been_left_behind(model):
    """The elastic part is zero before the tip is back at the surface, and the pull is whole there."""
    model = model.with_value("c1", 0.6)
    force = model.simulate([0.0, 0.1, 20.0, 20.01], DEPTH * np.array([0.0, 1.0, 1.0, 0.3]))
    assert force.normal_force[-1] == pytest.approx(-model.values["pull"].value * model.values["K"].value)
