"""Of the friction of a grasp: information adds and subtracts as that of normal variables does."""

import math

import pytest

from tests.grip.stages import put
from vegrip.grip.friction_belief import (
    begin_belief,
    believed_mean,
    believed_variance,
    expect_exponent,
    expect_finger,
)
from vegrip.grip.grasp_memory import BELIEF_MOST, BELIEF_ROW, GraspMemory

MS = 10**6


@pytest.fixture
def q() -> GraspMemory:
    """What three fingers share, each of which is believed to be another."""
    q = GraspMemory(3)
    begin_belief(q, 3, 0.03)
    expect_exponent(q, 0.15, 0.12**2)
    for i in range(3):
        expect_finger(q, i, -0.5 - 0.1 * i, 0.3 + 0.01 * i, 0.08)
        q.belief.load[i], q.belief.p[i * BELIEF_ROW + 3] = 0.7, 1e-3 * i
        q.belief.p[3 * BELIEF_ROW + i] = 1e-3 * i
    q.belief.version = 4.0
    return q


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


@pytest.mark.parametrize("less", [0.4, -0.2, 3.0])
def test_a_finger_is_asked_for_the_margin_at_the_friction_that_is_counted_on(
    kernels, f, t, q, monkeypatch, less
) -> None:
    """By a quantile of the belief, from 0 to five standard deviations; what is beyond is in the margin."""
    heard = []
    monkeypatch.setattr(kernels, "screen_slip", lambda *given: heard.append(given[2:]))
    i, mean, std = 1, believed_mean(q, 1), math.sqrt(believed_variance(q, 1) + 1e-6)
    q.release.counted[i], q.release.shift[i], q.witness.lack = mean - less, 0.2, -0.1
    put(kernels, f, t, SETUP_SHARES=1, SETUP_FINGER=i, RULE_WANTED_MARGIN=0.15, RULE_QUANTILE=1.6)
    f[kernels.FRI_EVENT] = 1.0
    for learned, stamp, seconds in ((0, 7 * MS, 0.0), (5 * MS, 7 * MS, 0.002)):
        put(kernels, f, t, TURN_LEARNED=learned, NEWS_STAMP=stamp)
        kernels.prepare_friction(f, t, q.array)
        assert heard.pop() == (i, pytest.approx(seconds))
    quantile = min(max(less / std, 0.0), 5.0)
    assert f[kernels.ASKED_QUANTILE] == pytest.approx(quantile)
    more = quantile * std - less
    assert f[kernels.ASKED_MARGIN] == pytest.approx(1.0 - 0.85 * math.exp(0.2 - 0.1 + more))
    law = [f[getattr(kernels, f"FRI_{name}")] for name in ("LN_MU", "EXPONENT", "EXPONENT_VAR", "VAR", "COV")]
    assert law == pytest.approx([-0.6, 0.15, 0.12**2, 0.31**2, 1e-3])
    assert (f[kernels.SHARED_BEFORE_VAR], f[kernels.FRI_EVENT], f[kernels.SHARED_SEEN]) == (law[3], 0.0, 4.0)
    put(kernels, f, t, SETUP_SHARES=0)
    kernels.prepare_friction(f, t, q.array)
    assert (f[kernels.ASKED_MARGIN], f[kernels.ASKED_QUANTILE]) == (0.15, 1.6)


@pytest.mark.parametrize(
    ("slides", "sound", "told"),
    [
        (0.95, 0.97, 1.0),
        (0.94, 0.97, 0.5),
        (0.5, 0.97, 0.5),
        (0.49, 0.97, 0.0),
        (0.49, 0.051, 0.0),
        (0.49, 1.0 - 0.95, 0.5),
        (0.95, 0.02, 1.0),
        (0.95, 0.0199, math.nan),
        (0.49, 0.0, math.nan),
    ],
)
def test_an_estimate_is_told_of_slip_what_is_believed_of_its_channel(
    kernels, f, q, monkeypatch, slides, sound, told
) -> None:
    heard = []
    monkeypatch.setattr(kernels, "hear_slip", lambda _, *given: heard.append(given))
    monkeypatch.setattr(kernels, "sound_channel", lambda *_: sound)
    f[kernels.SHARED_FLAG], f[kernels.SHARED_SPEED], q.slip.slides[2] = 1.0, -0.02, slides
    kernels.screen_slip(f, q.array, 2, 0.002)
    assert f[kernels.STATE_SLIP] == pytest.approx(told, nan_ok=True)
    assert heard == [(2, 0.002, 1.0, 0.02)]  # whichever way it slides


@pytest.mark.parametrize("unsound", [(), (1,), (BELIEF_MOST + 1,), (1, BELIEF_MOST + 1), (0, BELIEF_MOST)])
def test_a_channel_that_is_surely_wrong_is_missing_until_the_state_is_shown(
    kernels, f, t, q, unsound
) -> None:
    for at in range(2 * BELIEF_MOST):
        q.slip.sound[at] = 0.0 if at in unsound else 0.5
    for shares in (1, 0):
        put(kernels, f, t, SETUP_SHARES=shares, SETUP_FINGER=1, STATE_SLIP=1.0, STATE_SLIP_SPEED=0.3)
        kernels.hide_unsound(f, t, q.array)
        told = f[kernels.STATE_SLIP], f[kernels.STATE_SLIP_SPEED]
        hidden = [at in unsound and shares == 1 for at in (1, BELIEF_MOST + 1)]
        assert [math.isnan(one) for one in told] == hidden
        kernels.restore_slip(f, t)
        assert (f[kernels.STATE_SLIP], f[kernels.STATE_SLIP_SPEED]) == (1.0, 0.3)


@pytest.mark.parametrize(("shift", "started", "lowered_from"), [(0.0, 1, 3.0), (1e-9, 1, 2.0), (0.0, 0, 2.0)])
def test_what_a_finger_learns_of_its_state_reaches_the_grasp(
    kernels, f, t, q, monkeypatch, shift, started, lowered_from
) -> None:
    told: dict[str, tuple[float, ...]] = {}
    answers = {
        "touches": True,
        "utilised_friction": (0.3, 0.04),
        "follow_utilisation": 0.05,
        "armed_load": 1.2,
    }
    names = (
        *answers,
        "follow_forces",
        "watch_quiet",
        "note_slide",
        "decide",
        "widen_belief",
        "give_evidence",
    )
    for name in names:
        monkeypatch.setattr(
            kernels, name, lambda *given, name=name: told.update({name: given[1:]}) or answers.get(name)
        )
    put(kernels, f, t, SETUP_SHARES=1, SETUP_FINGER=2, SETUP_FINGERS=3, TURN_STARTED=started, GRIP_HELD=3.0,
        GRIP_LOWERED_FROM=2.0, STATE_TANGENTIAL_FORCE_X=3.0, STATE_TANGENTIAL_FORCE_Y=-4.0,
        STATE_NORMAL_FORCE=6.0, FRI_LOAD=-0.4, SHARED_LOAD_NOISE=0.01, RULE_WANTED_MARGIN=0.15)  # fmt: skip
    q.release.shift[2] = shift
    for learned, since, seconds in ((0, 0.1, 0.0), (5 * MS, 0.09, 0.03), (5 * MS, 0.0901, 0.03)):
        told.clear()
        q.belief.since = since
        put(kernels, f, t, TURN_LEARNED=learned, NEWS_STAMP=35 * MS)
        kernels.update_shared_friction(f, t, q.array)
        dt = pytest.approx(seconds)
        assert q.belief.since == pytest.approx(since + seconds / 3.0)
        assert ("widen_belief" in told) == (q.belief.since >= 0.1)
        assert told["follow_utilisation"] == (2, dt, 0.3, 0.04, -0.4, True)
        assert told["follow_forces"] == (2, dt, 6.0, 5.0, True)
        assert told["watch_quiet"] == (2, dt, 1.2, 0.01, True)
        assert told["note_slide"] == (2, 0.05)
        assert told["decide"][:4] == (2, dt, 0.15, True)
    assert (q.belief.load[2], t[kernels.TURN_LEARNED]) == (-0.4, 35 * MS)
    assert f[kernels.GRIP_LOWERED_FROM] == lowered_from


@pytest.mark.parametrize(
    ("changed", "command"),
    [
        ({}, 2.5),
        ({"TURN_STARTED": 0}, math.nan),
        ({"GRIP_ELAPSED": 0.0}, math.nan),
        ({"INPUT_DOUBTFUL": 1}, math.nan),
    ],
)
def test_a_load_leads_where_a_drive_follows_a_command(kernels, f, t, monkeypatch, changed, command) -> None:
    followed = []
    monkeypatch.setattr(kernels, "follow_drive", lambda _, *given: followed.append(given))
    monkeypatch.setattr(kernels, "lead_load", lambda *given: given[1:])
    numbers = {"TURN_STARTED": 1, "GRIP_ELAPSED": -math.inf, "INPUT_DOUBTFUL": 0, **changed}
    put(kernels, f, t, SETUP_FINGER=2, GRIP_HELD=2.5, STATE_NORMAL_FORCE=2.4, **numbers)
    put(kernels, f, t, TURN_LED=5 * MS, NEWS_STAMP=7 * MS)
    assert kernels.load_to_answer(f, t, None, 3.0, -4.0, 0.1) == (5.0, 0.1)
    assert followed == []
    put(kernels, f, t, SETUP_LEADS=1)
    dt = pytest.approx(0.002)
    assert kernels.load_to_answer(f, t, None, 3.0, -4.0, 0.1) == (2, dt, 3.0, -4.0, 0.1)
    assert followed == [(2, dt, pytest.approx(command, nan_ok=True), 2.4)]
    assert t[kernels.TURN_LED] == 7 * MS


@pytest.mark.parametrize("absent", ["REP_GAUGE", "REP_RADIUS"])
def test_a_contact_without_a_gauge_or_a_radius_tells_no_load(kernels, f, t, absent) -> None:
    told = {"REP_GAUGE": 0.5, "REP_RADIUS": 2e-3, "TAKEN_LOAD": 0.3, "REP_GAUGE_REL": 0.05}
    put(kernels, f, t, **told)
    assert kernels.utilised_friction(f, True) == (0.0, pytest.approx(0.05))  # no friction is believed yet
    put(kernels, f, t, **{absent: 0.0})
    assert math.isnan(kernels.armed_load(f, True))
    assert math.isnan(kernels.utilised_friction(f, True)[0])


@pytest.mark.parametrize(
    ("shares", "flag", "finger", "slips"),
    [(1, 0.0, 2, True), (1, 1.0, 1, False), (0, 1.0, 1, True), (0, math.nextafter(1.0, 0.0), 2, False)],
)
def test_a_finger_slips_by_what_is_believed_of_it_and_by_its_flag_where_it_is_alone(
    kernels, f, t, monkeypatch, shares, flag, finger, slips
) -> None:
    monkeypatch.setattr(kernels, "reacts", lambda _, i: i == 2)
    put(kernels, f, t, SETUP_SHARES=shares, SETUP_FINGER=finger, STATE_SLIP=flag)
    assert kernels.is_slipping(f, t, None) == slips
