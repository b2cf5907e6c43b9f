"""What is counted on, and when force is let go of: expected loss against quadrature and limits."""

import math

import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from vegrip.grip import force_release
from vegrip.grip.drive_lag import begin_drives, set_drives
from vegrip.grip.force_release import (
    LOOK,
    PAUSE,
    begin_release,
    cost_of_noticed,
    counted_on,
    decide,
    let_go,
    note_slide,
    reacts,
    set_risk,
    stated_std,
    take_back,
    watch_quiet,
)
from vegrip.grip.friction_belief import (
    absorb_hold,
    absorb_slide,
    begin_belief,
    believed_mean,
    believed_variance,
    expect_exponent,
    expect_finger,
)
from vegrip.grip.friction_numbers import RARE, RISE
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.slip_channels import begin_channels, follow_utilisation, hear_slip
from vegrip.grip.slip_witness import begin_witness, follow_forces, watch_part

MEAN, STD, EXPONENT, EXPONENT_STD, RISK, NOTICED = math.log(0.5), 0.35, 0.15, 0.12, 0.05, 0.24


def grasp(releases: bool = True, fingers: int = 2) -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, fingers, 0.0)
    expect_exponent(g, EXPONENT, EXPONENT_STD**2)
    for i in range(fingers):
        expect_finger(g, i, MEAN, STD, 0.08)
    begin_channels(g, 1e-3, 0.02)
    begin_witness(g, 0.01)
    begin_drives(g, 0.01)
    begin_release(g)
    set_risk(g, RISK, NOTICED, releases)
    for i in range(fingers):
        follow_forces(g, i, 1e-6, 2.0, 1.0, True)
        hear_slip(g, i, 1e-6, 0.0, math.nan)
    return g


def set_lags(g: GraspMemory, *lags: float) -> None:
    """Let these be the measured lags of the drives [s]."""
    for i, lag in enumerate(lags):
        g.drive.known[i], g.drive.state[3 * i] = 1.0, lag


def prove(g: GraspMemory, sound: float) -> None:
    g.slip.sound[0], g.slip.silent[0] = sound, 1.0 - sound - 1e-6
    g.slip.sound[1], g.slip.silent[1] = 0.1, 0.9


@pytest.mark.parametrize("load", [-2.0, 0.0, 1.1])
def test_where_no_slide_would_be_noticed_nor_would_a_change_of_friction(load: float) -> None:
    g = grasp(releases=False)
    g.belief.load[0] = load
    mean, std = MEAN - EXPONENT * load, math.hypot(STD, EXPONENT_STD * load)

    def loss(x: float) -> float:
        return 0.98 * norm.cdf(x, mean, std) + 0.02 * norm.cdf(x, mean, math.hypot(std, 0.4)) - RISK

    assert counted_on(g, 0) == pytest.approx(brentq(loss, -4.0, 1.0), abs=1e-3)
    assert counted_on(g, 0) < mean + norm.ppf(RISK) * std


def test_a_load_that_held_is_counted_on_though_no_slide_would_be_noticed() -> None:
    """It is no more than friction bears, whether the object holds or slides."""
    g = grasp(releases=False)
    before = counted_on(g, 0)
    absorb_hold(g, 0, MEAN, 0.01)
    assert before + 0.1 < counted_on(g, 0) < MEAN


def test_where_friction_is_lower_than_expected_that_is_counted_on_though_nothing_is_noticed() -> None:
    g = grasp(releases=False)
    absorb_slide(g, 0, math.log(0.15), 0.01)
    assert counted_on(g, 0) < math.log(0.15)


def test_where_every_slide_is_noticed_the_belief_alone_counts_at_the_larger_risk() -> None:
    g = grasp()
    prove(g, 1.0 - 1e-9)
    absorb_slide(g, 0, math.log(0.7), 0.01)
    mean, std = believed_mean(g, 0), math.sqrt(believed_variance(g, 0))
    assert counted_on(g, 0) == pytest.approx(mean + norm.ppf(NOTICED) * std, abs=1e-3)


@pytest.mark.parametrize(
    ("noticed", "p"), [(0.2, 0.0), (0.48, 0.0), (0.715, 0.475), (0.95, 0.95), (0.99, 0.99)]
)
def test_between_them_the_expected_loss_is_the_risk(noticed: float, p: float) -> None:
    g = grasp()
    prove(g, noticed)
    absorb_slide(g, 0, math.log(0.8), 0.01)
    mean, std = believed_mean(g, 0), math.sqrt(believed_variance(g, 0))

    def loss(x: float) -> float:
        believed, changed = norm.cdf(x, mean, std), norm.cdf(x, mean, math.hypot(std, 0.4))
        unnoticed = 0.98 * believed + 0.02 * changed
        return (1.0 - p) * unnoticed + p * RISK / NOTICED * believed - RISK

    assert counted_on(g, 0) == pytest.approx(brentq(loss, -3.0, 1.0), abs=1e-3)


def test_the_surer_a_slide_is_noticed_the_more_is_counted_on() -> None:
    found = []
    for p in (0.0, 0.3, 0.7, 0.99):
        g = grasp()
        prove(g, p)
        found.append(counted_on(g, 0))
    assert found == sorted(found)
    assert found[0] < found[-1]


def held(g: GraspMemory, u: float) -> None:
    """Let both fingers hold this utilisation in quiet for a while."""
    for _ in range(4000):
        for i in range(2):
            follow_utilisation(g, i, 0.002, u, 0.02, 0.0, True)
            watch_quiet(g, i, 0.002, 1.0, 0.01, True)
            follow_forces(g, i, 0.002, 1.0 / u, 1.0, True)
            decide(g, i, 0.002, 0.15, True, False)


@pytest.mark.parametrize(
    ("sound", "releases", "lets_go"),
    [(0.99, True, True), (0.48, True, True), (0.3, True, False), (0.01, True, False), (0.99, False, False)],
    ids=["proven", "not proven yet", "doubted", "named", "switched off"],
)
def test_force_is_let_go_of_while_a_slide_would_be_noticed(sound, releases, lets_go) -> None:  # type: ignore[no-untyped-def]
    g = grasp(releases)
    prove(g, sound)
    held(g, 0.42)
    assert (g.release.shift[0] > RISE) == lets_go


@pytest.mark.parametrize("proven", [True, False])
def test_what_was_let_go_of_is_restored_as_soon_as_no_slide_would_be_told(*, proven: bool) -> None:
    """The flags are not sensed any more: neither has held what only they would have told of."""
    g = grasp()
    prove(g, 0.99 if proven else 0.48)
    held(g, 0.5)
    assert g.release.shift[0] > 0.02
    before = believed_mean(g, 0)
    for i in range(2):
        hear_slip(g, i, 0.002, math.nan, math.nan)
    decide(g, 0, 0.002, 0.15, True, False)
    assert g.release.shift[0] == g.release.shift[1] == 0.0
    assert believed_mean(g, 0) == before


@pytest.mark.parametrize(("lag", "lets_go"), [(0.025, True), (0.028, False)])
def test_where_a_drive_is_late_the_load_is_no_witness(lag: float, *, lets_go: bool) -> None:
    """What N falls on by is lost, too: 0.02 + 5 / s * lag may be 0.15."""
    g = grasp()
    prove(g, 0.48)
    set_lags(g, 0.01, lag)
    held(g, 0.42)
    assert (g.release.shift[0] > RISE) == lets_go


def test_what_is_known_well_is_not_let_go_of() -> None:
    g = grasp()
    prove(g, 0.999)
    for k in range(40):
        g.belief.load[k % 2] = 0.0
        absorb_slide(g, k % 2, math.log(0.5), 0.01)
    held(g, 0.35)
    assert g.release.shift[0] == 0.0


def test_a_slide_takes_all_back_and_waits() -> None:
    g = grasp()
    prove(g, 0.99)
    held(g, 0.5)
    before = believed_mean(g, 0)
    g.slip.slides[1] = 0.9
    decide(g, 1, 0.002, 0.15, True, False)
    assert believed_mean(g, 0) == before  # what slid has not held
    assert g.release.shift[0] == g.release.shift[1] == 0.0
    assert g.release.pause == pytest.approx(PAUSE)
    assert g.release.ends == pytest.approx(2.0 * (0.02 + LOOK))
    assert not reacts(g, 1)  # it ends with what was let go of


def test_a_load_that_changes_takes_all_back_and_what_has_held_is_learned() -> None:
    g = grasp()
    prove(g, 0.99)
    held(g, 0.5)
    before, g.release.still[0] = believed_mean(g, 0), 0.0
    decide(g, 0, 0.002, 0.15, True, True)
    assert g.release.shift[0] == 0.0
    assert believed_mean(g, 0) > before + 0.03


@pytest.mark.parametrize(
    ("sound", "load", "teaches"),
    [(0.48, 0.9, False), (0.48, 1.2, True), (0.99, 0.9, True), (0.99, 1.2, True)],
    ids=["not proven, falls", "not proven, rises", "proven, falls", "proven, rises"],
)
def test_a_load_that_falls_with_the_force_may_be_a_slide_until_a_channel_is_proven(
    sound: float, load: float, *, teaches: bool
) -> None:
    g = grasp()
    prove(g, sound)
    held(g, 0.5)
    g.witness.first = g.witness.lagging = 4.0  # N falls from now on
    before = believed_mean(g, 0)
    for k in range(40):
        for i in range(2):
            part = k / 39.0  # of the change
            follow_forces(g, i, 0.002, 2.0 * 0.75**part, load**part, True)
            changed = watch_quiet(g, i, 0.002, load**part, 0.01, True)
            decide(g, i, 0.002, 0.15, True, changed)
    assert g.release.shift[0] == 0.0
    assert (believed_mean(g, 0) > before + 0.01) is teaches


def test_what_each_finger_has_held_counts_by_itself_whatever_the_exponent_becomes_meanwhile(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The hold of one teaches the exponent; what the other has shown was referred by the one of before."""
    told = []

    def absorb(g: GraspMemory, i: int, ln_u: float, noise: float) -> None:
        told.append(ln_u)
        absorb_hold(g, i, ln_u, noise)

    monkeypatch.setattr(force_release, "absorb_hold", absorb)
    g = grasp()
    for i in range(2):
        g.belief.load[i] = 1.1  # at 15 N
        g.release.shift[i], g.slip.shown[i] = 0.3, MEAN + 0.2
    take_back(g, True)
    assert g.belief.mean[2] < EXPONENT - 0.01
    assert told == pytest.approx([MEAN + 0.2 - 1.1 * EXPONENT] * 2)


@pytest.mark.parametrize(("slides", "teaches"), [(True, False), (False, True)])
def test_a_finger_that_slides_alone_has_not_held_though_the_others_take_its_load(
    *, slides: bool, teaches: bool
) -> None:
    """Index slides: its T is mu N, thumb takes the rest, the sum stays; no channel is proven."""
    g = grasp()
    prove(g, 0.48)
    held(g, 0.5)
    for k in range(40):
        fallen = 0.9 ** (k / 39.0)
        pulls = (2.0 - fallen, fallen) if slides else (1.0, 1.0)
        for i in range(2):
            follow_forces(g, i, 0.002, 2.0 * fallen, pulls[i], True)
            watch_part(g, i, 0.002, 1.0)
    take_back(g, True)
    assert (g.belief.site[1] > 0.0) is teaches  # what its hold has taught
    assert g.belief.site[0] > 0.0


def test_while_a_load_steps_its_mean_follows_whatever_is_noticed_on_the_way() -> None:
    """What is steady begins anew with each change, and the mean that it is compared with does not."""
    g, changes = grasp(), 0
    watch_quiet(g, 0, 0.002, 1.0, 0.01, True)
    for k in range(1, 51):
        changes += watch_quiet(g, 0, 0.002, 2.0, 0.01, True)
        assert g.release.smooth[0] == pytest.approx(2.0 - math.exp(-0.002 * k / LOOK), rel=1e-12)
    assert changes > 1


def test_a_slide_costs_as_much_as_the_object_slides_until_the_drive_answers() -> None:
    """By the square of the time, and never more than one that is not noticed."""
    g = grasp()
    for lag, part in ((0.015, 1.0), (0.06, 4.0), (0.4, math.inf)):
        set_lags(g, lag, 0.01)
        assert cost_of_noticed(g) == pytest.approx(min(RISK / NOTICED * part, 1.0))


def test_a_lag_that_is_stated_counts_until_it_is_measured_but_never_less_than_is_seen() -> None:
    """15 ms is usual; with 10 ms of the look and 20 ms of the delay it is what costs are stated for."""
    g = grasp()
    part = cost_of_noticed(g)
    assert part == pytest.approx(RISK / NOTICED)
    set_drives(g, 0.01, 4.0)
    assert cost_of_noticed(g) == pytest.approx(part)
    set_drives(g, 0.06, 4.0)
    assert cost_of_noticed(g) == pytest.approx(4.0 * part)
    set_lags(g, 0.015, 0.015)
    assert cost_of_noticed(g) == pytest.approx(part)


def test_a_finger_that_lets_go_of_the_object_is_not_let_go_of() -> None:
    g = grasp()
    prove(g, 0.99)
    held(g, 0.42)
    watch_quiet(g, 0, 0.002, math.nan, 0.01, False)
    assert g.release.shift[0] == 0.0
    assert not watch_quiet(g, 0, 0.002, 3.0, 0.01, True)  # another contact, whose load is its first
    assert g.release.smooth[0] == g.release.steady[0] == 3.0


def test_what_is_stated_is_wider_than_what_is_believed_by_what_changes_unfelt() -> None:
    assert stated_std(0.0) == pytest.approx(0.1)
    assert stated_std(0.3) == pytest.approx(math.hypot(0.3, 0.1))


@pytest.mark.parametrize(
    ("proven", "u", "less"),
    [
        (True, 0.42, 0.3), (True, 1.2, 0.3), (True, 0.2, 1.5), (True, 1e-4, 0.3), (True, 0.42, 0.05),
        (False, 0.42, 0.3),
    ],
    ids=["worth it", "credible", "quickest", "far below", "worth nothing", "by the load alone"],
)  # fmt: skip
def test_force_is_let_go_of_as_quickly_as_what_is_held_for_want_of_knowledge_is_worth(
    proven: bool, u: float, less: float
) -> None:
    """db/dt = rate s (1 - Phi(z)) / phi(z) within QUICK, and no further than the grip follows."""
    g = grasp()
    prove(g, 0.99 if proven else 0.48)
    g.belief.load[0], g.slip.level[0] = 0.7, math.log(u) + EXPONENT * 0.7
    mean, std = believed_mean(g, 0), math.sqrt(believed_variance(g, 0) + 1e-6)
    g.release.counted[0] = counted = mean - less
    z = max((math.log(u) - mean) / std, -5.0)
    rate, most = 5.0, math.inf
    if proven:
        worth = max(math.exp(less) - 1.08, 0.0) / (2 * 2.0)
        rate, most = min(worth * std * norm.sf(z) / norm.pdf(z), 5.0), mean + 2.0 * std
    most = min(most, math.log(u) + 0.35 * rate) - math.log(1.0 - 0.15) - counted
    for seconds in (0.002, 1e3):
        expected = max(g.release.shift[0], min(g.release.shift[0] + rate * seconds, most))
        let_go(g, 0, seconds, 0.15, True)
        assert g.release.shift[0] == pytest.approx(expected, rel=1e-9)
        if not proven:
            break  # in a thousand seconds a load tells of nothing


@pytest.mark.parametrize(
    ("still", "pause", "touches", "quiet"),
    [
        (0.15, 0.0, True, True),
        (0.1499, 0.0, True, False),
        (0.0, 0.0, True, False),
        (0.5, 1e-9, True, False),
        (0.5, 0.0, False, False),
    ],
)
def test_force_is_let_go_of_in_quiet_alone(still: float, pause: float, touches: bool, quiet: bool) -> None:
    """No load has changed for 0.15 s, of any finger, and the rest after a slide is over."""
    g = grasp()
    prove(g, 0.99)
    g.slip.level[0], g.release.counted[0] = math.log(0.42), MEAN - 0.3
    g.release.still[1], g.release.pause = still, pause
    let_go(g, 0, 0.002, 0.15, touches)
    assert (g.release.shift[0] > 0.0) == quiet


def test_rests_run_out_by_the_time_of_all_fingers_and_not_beyond_their_end() -> None:
    g = grasp()
    g.release.pause, g.release.ends = 0.3, 0.05
    for k, left in enumerate([(0.275, 0.025), (0.25, 0.0), (0.225, 0.0), (0.2, 0.0)]):
        decide(g, k % 2, 0.05, 0.15, True, False)
        assert (g.release.pause, g.release.ends) == pytest.approx(left)


@pytest.mark.parametrize(("lowered", "reacting"), [(0.05, True), (0.051, False)])
def test_a_slide_that_hardly_anything_was_let_go_of_for_is_reacted_to(
    lowered: float, *, reacting: bool
) -> None:
    g = grasp()
    g.release.shift[0] = g.release.shift[1] = lowered
    g.slip.slides[1] = 0.5
    decide(g, 1, 0.002, 0.15, True, False)
    assert reacts(g, 1) == reacting


@pytest.mark.parametrize(
    ("silence", "sound", "doubted"),
    [
        (PAUSE, 0.95, 0.0), (PAUSE - 1e-9, 0.95, 1.0), (PAUSE, 0.9499, 1.0), (PAUSE, RARE, 1.0),
        (0.0, 0.0199, 0.0),
    ],
)  # fmt: skip
def test_a_slide_is_doubted_until_its_proven_channel_has_been_quiet_or_is_a_liar(
    silence: float, sound: float, doubted: float
) -> None:
    g = grasp()
    g.belief.doubted[0], g.slip.teacher[0] = 1.0, 1.0
    g.slip.silence[1], g.slip.sound[1] = silence, sound
    note_slide(g, 0, 0.0)
    assert g.belief.doubted[0] == doubted


def test_a_slide_teaches_anew_once_its_chance_was_below_a_twentieth() -> None:
    g = grasp()
    g.slip.top[0], taught = math.log(0.3), []
    for slides in (0.949, 0.95, 0.5, 0.951, 0.0501, 0.95, 0.0499, 0.95):
        g.slip.slides[0] = slides
        before = g.belief.version
        note_slide(g, 0, 0.02)
        taught.append(g.belief.version > before)
    assert taught == [False, True, False, False, False, False, False, True]


@pytest.mark.parametrize(("to", "noise"), [(1.2, 0.01), (0.7, 0.0), (3.0, 0.1)])
def test_a_load_has_changed_where_its_mean_is_a_twentieth_and_two_deviations_off_the_steady_one(
    to: float, noise: float
) -> None:
    """Both follow it exponentially, within 10 ms and half a second; the steady one begins anew there."""
    g, mean, steady, still = grasp(), 1.0, 1.0, 0.0
    watch_quiet(g, 0, 0.004, 1.0, noise, True)
    still, changes = 0.004, []
    for _ in range(60):
        mean = to + (mean - to) * math.exp(-0.4)
        steady = mean + (steady - mean) * math.exp(-0.008)
        still += 0.004
        has_changed = abs(mean - steady) > 0.05 * steady + 2.0 * noise
        assert watch_quiet(g, 0, 0.004, to, noise, True) == has_changed
        steady, still = (mean, 0.0) if has_changed else (steady, still)
        assert (g.release.smooth[0], g.release.steady[0]) == pytest.approx((mean, steady), rel=1e-12)
        assert g.release.still[0] == pytest.approx(still)
        changes.append(has_changed)
    assert any(changes)
    assert not all(changes)


def test_a_load_that_asks_for_next_to_nothing_is_no_number_too_large() -> None:
    """Of a friction that is known well the next slide lies so far off that its distance has no bound."""
    g = grasp()
    prove(g, 0.99)
    for k in range(20):
        absorb_slide(g, k % 2, MEAN, 0.01)
    held(g, 1e-5)
    assert math.isfinite(g.release.shift[0])
