"""Of the friction of a grasp: information adds and subtracts as that of normal variables does."""

import math

import pytest


def put(kernels, f, *, before=(-0.4, 0.09), now=(-0.5, 0.04), site=(0.0, 0.0), widest=0.25):
    f[kernels.SHARED_BEFORE], f[kernels.SHARED_BEFORE_VAR] = before
    f[kernels.FRI_LN_MU], f[kernels.FRI_VAR] = now
    f[kernels.SHARED_SITE], f[kernels.SHARED_SITE_WEIGHTED] = site
    f[kernels.SHARED_WIDEST] = widest


def belief(kernels, f):
    return [
        f[place] for place in (kernels.FRI_LN_MU, kernels.FRI_VAR, kernels.FRI_BASE_LN, kernels.FRI_BASE_VAR)
    ]


def test_before_the_present_loading_friction_is_known_without_the_evidence_of_the_loading(kernels, f) -> None:
    """Evidence of ln mu = -0.6 +- 0.5 is taken out of -0.5 +- 0.2."""
    put(kernels, f, site=(4.0, 4.0 * -0.6))
    kernels.believe_friction(f, -0.5, 0.04)
    left = 25.0 - 4.0
    assert belief(kernels, f) == pytest.approx([-0.5, 0.04, (-0.5 * 25.0 + 0.6 * 4.0) / left, 1.0 / left])


@pytest.mark.parametrize(
    ("site", "variance"),
    [(0.0, 0.04), (21.5, 0.04), (4.0, 0.0)],
    ids=["no evidence", "nearly all is evidence", "known exactly"],
)
def test_without_evidence_or_with_hardly_anything_beside_it_both_are_the_same(
    kernels, f, site, variance
) -> None:
    put(kernels, f, site=(site, -0.6 * site))
    kernels.believe_friction(f, -0.5, variance)
    assert belief(kernels, f) == [-0.5, variance, -0.5, variance]


def test_evidence_is_what_the_belief_has_more_than_before(kernels, f, monkeypatch) -> None:
    given = []
    monkeypatch.setattr(kernels, "absorb_evidence", lambda _, *values: given.append(values))
    put(kernels, f, site=(2.0, -1.0))
    kernels.give_evidence(f, None, 3, refused=False)
    assert given == [(3, -0.4, 0.09, -0.5, 0.04)]
    assert f[kernels.SHARED_SITE] == pytest.approx(2.0 + 1.0 / 0.04 - 1.0 / 0.09)
    assert f[kernels.SHARED_SITE_WEIGHTED] == pytest.approx(-1.0 - 0.5 / 0.04 + 0.4 / 0.09)


def test_evidence_of_slip_that_is_felt_late_is_refused(kernels, f, monkeypatch) -> None:
    refused = []
    monkeypatch.setattr(kernels, "refuse_evidence", refused.append)
    put(kernels, f, site=(2.0, -1.0))
    kernels.give_evidence(f, "grasp", 3, refused=True)
    assert refused == ["grasp"]
    assert f[kernels.SHARED_SITE] == 2.0


@pytest.mark.parametrize(("now", "widened"), [(0.09, False), (0.8, True)])
def test_a_new_contact_widens_the_own_share(kernels, f, monkeypatch, now, widened) -> None:
    told = []
    monkeypatch.setattr(kernels, "widen_own", lambda _, *values: told.append(values))
    put(kernels, f, now=(-0.4, now))
    kernels.give_evidence(f, None, 3, refused=True)
    assert told == ([(3, 0.8)] if widened else [])


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
    assert kernels.told_friction(f, t, mu, std) == pytest.approx((mu, std), nan_ok=True)


def test_a_finger_that_shares_tells_the_friction_that_may_have_changed(kernels, f, t) -> None:
    """What is believed is the median, and its std, as a share of it, that of the logarithm."""
    f[kernels.SHARED_LEVEL], f[kernels.SHARED_SPREAD], f[kernels.SHARED_UNKNOWN] = math.log(0.9), 0.1, 1.0
    assert kernels.told_friction(f, t, 0.6, 0.06) == (0.6, 0.06)
    t[kernels.SETUP_SHARES] = 1
    mean, relative = kernels.stated_friction(math.log(0.6), 0.1, math.log(0.9), 0.1, 1.0)
    mu, std = kernels.told_friction(f, t, 0.6, 0.06)
    assert math.log(mu) == pytest.approx(mean)
    assert std / mu == pytest.approx(relative)
    assert relative > 0.1  # it may be what it was before it fell
