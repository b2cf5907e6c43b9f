"""Of the friction of a grasp: information adds and subtracts as that of normal variables does."""

import math

import pytest


def test_a_new_contact_widens_the_own_share_and_a_look_does_not(kernels, f, monkeypatch) -> None:
    told = []
    monkeypatch.setattr(kernels, "widen_own", lambda _, *values: told.append(values))
    f[kernels.FRI_EVENT], f[kernels.SHARED_BEFORE_VAR] = 0.0, 0.09
    for now in (0.09, 0.0925):
        f[kernels.FRI_VAR] = now
        kernels.give_evidence(f, None, 3)
    assert told == [(3, pytest.approx(0.0025))]


@pytest.mark.parametrize(("event", "absorbed"), [(2.0, 1), (1.0, 0), (0.0, 0)], ids=["held", "slid", "none"])
def test_what_held_is_evidence_and_the_slides_of_the_finger_itself_are_not(
    kernels, f, monkeypatch, event, absorbed
) -> None:
    """Slides teach the grasp when its channels are believed."""
    given, refused = [], []
    monkeypatch.setattr(kernels, "absorb_hold", lambda _, *values: given.append(values))
    monkeypatch.setattr(kernels, "refuse_evidence", refused.append)
    f[kernels.FRI_EVENT], f[kernels.FRI_EVENT_LN_U], f[kernels.FRI_EVENT_NOISE] = event, -0.7, 0.01
    f[kernels.FRI_VAR] = f[kernels.SHARED_BEFORE_VAR] = 0.09
    kernels.give_evidence(f, "grasp", 3)
    assert given == [(3, -0.7, 0.01)] * absorbed
    assert refused == ["grasp"] * (event == 1.0)


def test_the_utilisation_owes_nothing_to_what_is_believed_of_friction(kernels, f) -> None:
    f[kernels.REP_GAUGE], f[kernels.REP_RADIUS], f[kernels.REP_MU] = 0.5, 2e-3, 0.6
    f[kernels.REP_GAUGE_ABS] = 0.02
    for mu_std in (0.0, 0.03, 0.06):
        f[kernels.REP_MU_STD] = mu_std
        f[kernels.REP_GAUGE_REL] = math.hypot(0.05, mu_std / 0.6)
        u, relative = kernels.utilised_friction(f, True)
        assert u == pytest.approx(0.3)
        assert relative == pytest.approx(math.hypot(0.05, 0.04))
    assert math.isnan(kernels.utilised_friction(f, False)[0])


def test_the_torque_counts_in_the_load_as_a_force_at_the_contact_radius(kernels, f) -> None:
    f[kernels.REP_GAUGE], f[kernels.REP_RADIUS] = 0.5, 2e-3
    f[kernels.TAKEN_LOAD], f[kernels.TAKEN_TORQUE] = 0.3, 8e-4
    assert kernels.armed_load(f, True) == pytest.approx(0.5)
    f[kernels.TAKEN_TORQUE] = math.nan
    assert kernels.armed_load(f, True) == pytest.approx(0.3)
    assert math.isnan(kernels.armed_load(f, False))


@pytest.mark.parametrize(("mu", "std"), [(0.0, 0.1), (-0.2, 0.1), (math.inf, 0.1), (math.nan, 0.1)])
def test_what_is_no_friction_is_told_as_it_is_believed(kernels, f, t, mu, std) -> None:
    t[kernels.SETUP_SHARES] = 1
    assert kernels.stated_friction(f, t, mu, std) == pytest.approx((mu, std), nan_ok=True)


def test_a_finger_that_shares_tells_the_friction_that_may_have_changed(kernels, f, t) -> None:
    assert kernels.stated_friction(f, t, 0.6, 0.06) == (0.6, 0.06)
    t[kernels.SETUP_SHARES] = 1
    mu, std = kernels.stated_friction(f, t, 0.6, 0.06)
    assert mu == 0.6
    assert std / mu == pytest.approx(math.hypot(0.1, 0.1))
