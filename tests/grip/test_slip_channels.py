"""Channels that are sound, silent or faulty are told apart by what they say, and by what the load shows."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import norm

from vegrip.grip.force_release import note_slide
from vegrip.grip.friction_belief import (
    absorb_hold,
    absorb_slide,
    begin_belief,
    expect_exponent,
    expect_finger,
    void_slides,
)
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.slip_channels import (
    DETECTS,
    EVEN,
    FALSE,
    LOOK,
    RARE,
    SCATTER,
    SURE,
    UNSURE,
    USUAL,
    begin_channels,
    faulty,
    follow_utilisation,
    hear_slip,
    is_unsound,
    judge_slide,
    likely_slide,
    noticed,
    others_stay,
    refer_anew,
    sound_channel,
    teller,
)

DT, DELAY, MU = 0.005, 0.02, 0.5


def grasp(fingers: int = 2, std: float = 0.35) -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, fingers, 0.03)
    expect_exponent(g, 0.0, 0.0)
    for i in range(fingers):
        expect_finger(g, i, math.log(MU), std, 0.08)
        g.witness.forces[i] = 3.0
    begin_channels(g, 1e-3, DELAY)
    return g


def run(
    g: GraspMemory, seconds: float, u: Callable[[float], float], flag: Callable[[float], float], i: int = 0
) -> None:
    """Let finger ``i`` be loaded and say what its flag says, after so many seconds."""
    for k in range(round(seconds / DT)):
        t = k * DT
        hear_slip(g, i, DT, flag(t), math.nan)
        follow_utilisation(g, i, DT, u(t), 0.02, 0.0, not math.isnan(u(t)))


def rising(to: float, seconds: float) -> Callable[[float], float]:
    return lambda t: 0.1 * (to / 0.1) ** min(t / seconds, 1.0)


QUIET, ALWAYS = (lambda _: 0.0), (lambda _: 1.0)


def probabilities(g: GraspMemory, at: int = 0) -> tuple[float, float, float]:
    return g.slip.sound[at], g.slip.silent[at], faulty(g, at)


def test_silence_proves_nothing() -> None:
    g = grasp()
    run(g, 30.0, rising(0.3, 1.0), QUIET)
    assert probabilities(g)[0] == pytest.approx(1.0 - EVEN - RARE, abs=0.02)


def test_slip_that_the_load_makes_likely_proves_a_channel_for_a_while() -> None:
    g = grasp()
    run(g, 2.0, rising(0.5, 2.0), lambda t: float(t > 1.97))
    assert g.slip.sound[0] > SURE
    assert g.slip.slides[0] > SURE
    run(g, 30.0, rising(0.2, 0.1), QUIET)
    assert 0.6 < g.slip.sound[0] < SURE


def test_slip_far_below_what_was_held_is_not_believed_of_one_that_is_not_proven() -> None:
    g = grasp()
    run(g, 2.0, rising(0.4, 1.0), QUIET)
    run(g, 1.0, lambda _: 0.15, lambda t: float(t > 0.5))
    assert probabilities(g)[2] > EVEN
    assert g.slip.slides[0] < EVEN


def test_slip_that_goes_on_though_the_load_has_fallen_since_it_began_is_a_lie() -> None:
    g = grasp()
    run(g, 2.0, rising(0.4, 1.0), QUIET)
    run(g, 1.0, lambda t: 0.15 if t < 0.6 else 0.1, lambda t: float(t > 0.5))
    assert probabilities(g)[2] > SURE
    assert is_unsound(g, 0)
    assert teller(g, 0) == 0
    assert g.slip.slides[0] < UNSURE


def slides_of_both(touches: bool, friction: float) -> tuple[float, float]:
    """Hold 0.8 with proven channels; let go and grip anew, or not; slide at ``friction``, which both tell.

    Return the larger probability of a slide and that of a sound channel, the least of both.
    """
    g = grasp(std=0.1)
    for i in (0, 1):
        g.belief.mean[i] = math.log(0.9)
        g.slip.sound[i], g.slip.silent[i] = 0.97, 0.025
        run(g, 2.0, rising(0.8, 1.0), QUIET, i)
        if not touches:
            run(g, 0.5, lambda _: math.nan, QUIET, i)
    slid = 0.0
    for k in range(40):
        for i in (0, 1):
            hear_slip(g, i, DT, float(k >= 24), math.nan)
            follow_utilisation(g, i, DT, friction * min(0.1 + 0.05 * k, 1.0), 0.02, 0.0, True)
        slid = max(slid, g.slip.slides[0])
    return slid, min(g.slip.sound[0], g.slip.sound[1])


@pytest.mark.parametrize("friction", [0.3, 0.4, 0.6])
def test_what_a_former_contact_has_held_makes_no_liars_of_those_that_tell_of_the_next(
    friction: float,
) -> None:
    slid, sound = slides_of_both(touches=False, friction=friction)
    assert slid > SURE
    assert sound > SURE


@pytest.mark.parametrize("friction", [0.3, 0.4, 0.6])
def test_two_proven_channels_are_believed_of_faces_as_wet_as_any_that_are_published(friction: float) -> None:
    slid, sound = slides_of_both(touches=True, friction=friction)
    assert slid > SURE
    assert sound > EVEN


def test_wet_faces_are_believed_of_proven_channels_though_more_was_held_before() -> None:
    g = grasp(std=0.1)
    for i in (0, 1):
        g.slip.sound[i], g.slip.silent[i] = 0.99, 0.005
        run(g, 2.0, rising(0.45, 1.0), QUIET, i)
    slid = []
    for k in range(40):
        u = 0.45 * (0.85 if k < 20 else 0.62)  # unloaded slowly; then friction is 0.62 of what it was
        for i in (0, 1):
            hear_slip(g, i, DT, float(k >= 22), math.nan)
            follow_utilisation(g, i, DT, u, 0.02, 0.0, True)
        slid.append(g.slip.slides[0])
    assert max(slid) > SURE
    assert g.slip.sound[0] > SURE


def test_faces_that_go_on_getting_wet_are_believed_again_a_moment_later() -> None:
    """The grip has grown after the first slide; a fifth of a second later friction is lower still."""
    g = grasp(std=0.1)
    for i in (0, 1):
        g.slip.sound[i], g.slip.silent[i] = 0.99, 0.005
        run(g, 2.0, rising(0.45, 1.0), QUIET, i)
    slid = []
    for k in range(60):
        u, says = (0.4, k >= 2) if k < 5 else (0.25, k >= 40)
        for i in (0, 1):
            hear_slip(g, i, DT, float(says), math.nan)
            follow_utilisation(g, i, DT, u, 0.02, 0.0, True)
            note_slide(g, i, 0.02)
        slid.append(max(g.slip.slides[0], g.slip.slides[1]))
    assert min(max(slid[:5]), max(slid[40:])) > SURE
    assert noticed(g) > SURE
    assert sound_channel(g, 0) > EVEN
    assert math.exp(g.belief.mean[0]) < 0.33


@pytest.mark.parametrize(
    ("unsure", "top", "teaches"),
    [
        (0.0, -0.9, True),
        (SCATTER, -0.9, True),
        (math.nextafter(SCATTER, 1.0), -0.9, False),
        (0.0, -math.inf, False),
    ],
    ids=["known load", "just so", "load in noise", "no load seen"],
)
def test_a_slide_teaches_once_and_only_where_its_load_is_known(
    unsure: float, top: float, *, teaches: bool
) -> None:
    """As much as one slide of that utilisation, whose variance is that of slides and of the load."""
    g, told = grasp(), grasp()
    g.slip.slides[0], g.slip.top[0], g.slip.silence[0] = SURE, top, 0.0
    if teaches:
        absorb_slide(told, 0, top, SCATTER**2 + unsure**2)
    for _ in range(2):
        note_slide(g, 0, unsure)
        assert list(g.belief.mean) == pytest.approx(list(told.belief.mean), rel=1e-12)
        assert list(g.belief.p) == pytest.approx(list(told.belief.p), rel=1e-12)


@pytest.mark.parametrize("share", [0.02, 0.3])
def test_flags_at_random_are_lies_within_two_seconds(share: float) -> None:
    g, rng = grasp(), np.random.default_rng(3)
    run(g, 2.0, rising(0.3, 0.5), QUIET)
    run(g, 2.0, lambda _: 0.2, lambda _: float(rng.random() < share))
    assert g.slip.sound[0] < UNSURE


def test_a_slide_that_goes_on_while_n_grows_is_one_and_a_flag_that_stays_while_u_falls_lies() -> None:
    """While it slides T = mu N, so u stays; a stuck flag stays though the grip has grown."""
    slides, stuck = grasp(), grasp()
    for g in (slides, stuck):
        run(g, 1.0, rising(0.45, 1.0), lambda t: float(t > 0.95))
    run(slides, 0.2, lambda _: 0.45, ALWAYS)
    run(stuck, 0.3, lambda t: 0.45 * math.exp(-6.0 * t), ALWAYS)
    assert slides.slip.slides[0] > SURE
    assert slides.slip.sound[0] > SURE
    assert stuck.slip.sound[0] < UNSURE


@pytest.mark.parametrize("looks", [0.3, 1.0])
@pytest.mark.parametrize(("stays", "odds"), [(0.0, 50.0), (0.25, 50.0), (0.25, 1e9), (1.0, 50.0)])
def test_a_look_of_slip_that_goes_on_is_as_likely_as_the_table_has_it(
    stays: float, odds: float, looks: float
) -> None:
    """Sound: stays DETECTS + (1 - stays) FALSE; faulty: DETECTS. By that the odds of a slide fall."""
    g = grasp()
    g.slip.sound[0], g.slip.silent[0] = USUAL, EVEN  # so that time changes nothing
    g.slip.says[0], g.slip.stays[0], g.slip.odds[0], g.slip.shows[0] = 1.0, stays, odds, 1.0
    hear_slip(g, 0, looks * LOOK, 1.0, math.nan)
    sound = ((stays * DETECTS + (1.0 - stays) * FALSE) / DETECTS) ** looks
    assert g.slip.sound[0] / faulty(g, 0) == pytest.approx(USUAL * sound / RARE, rel=1e-3)
    assert g.slip.odds[0] == pytest.approx(odds * sound)
    assert g.slip.shows[0] == pytest.approx(min(1.0 - looks * math.log(FALSE), math.log(1.0 + odds * sound)))


@pytest.mark.parametrize("p", [1e-3, 0.02, 0.2, 0.5])
@pytest.mark.parametrize(("sound", "faulty"), [(0.48, 0.02), (0.02, 0.9), (0.97, 0.01)])
def test_a_report_makes_a_slide_as_likely_as_the_table_of_all_cases_has_it(
    p: float, sound: float, faulty: float
) -> None:
    """Finger slides or not, channel sound or faulty: its chance to begin to report, and nine looks more."""
    g = grasp()
    hear_slip(g, 0, LOOK, 0.0, math.nan)
    g.slip.sound[0], g.slip.silent[0], g.slip.likely[0] = sound, 1.0 - sound - faulty, p
    g.slip.stays[0] = 1.0
    for _ in range(10):
        hear_slip(g, 0, LOOK, 1.0, math.nan)
    slides = p * (sound * DETECTS**10 + faulty * RARE * DETECTS**9)
    holds = (1.0 - p) * (sound * FALSE * DETECTS**9 + faulty * RARE * DETECTS**9)
    never = (1.0 - p) * faulty * RARE * DETECTS**9  # a sound one errs anew at each look
    assert g.slip.slides[0] == pytest.approx(slides / (slides + never), abs=0.01)
    assert holds >= never


def test_a_channel_that_says_slip_when_it_is_first_heard_may_have_said_so_all_the_time() -> None:
    """Stuck or inverted as likely as not, it is no slide at p = 0.02; one that begins to say so later is."""
    stuck, begins = grasp(), grasp()
    hear_slip(begins, 0, LOOK, 0.0, math.nan)
    for g in (stuck, begins):
        g.slip.likely[0], g.slip.stays[0] = RARE, 1.0
        for _ in range(10):
            hear_slip(g, 0, LOOK, 1.0, math.nan)
    assert stuck.slip.slides[0] < EVEN < SURE < begins.slip.slides[0]
    assert stuck.slip.sound[0] < 0.5 < begins.slip.sound[0]


@pytest.mark.parametrize(("sound", "stays"), [(0.948, True), (0.01, False)])
def test_a_slide_is_revoked_only_once_its_channel_is_unsound(sound: float, *, stays: bool) -> None:
    """The first report of a new channel leaves it 0.948, and of wet faces it is a slide."""
    g = grasp()
    run(g, 1.0, rising(0.25, 1.0), QUIET)
    run(g, 0.1, lambda _: 0.25, ALWAYS)
    assert g.belief.doubted[0] == 0.0
    g.slip.slides[0], g.slip.top[0] = 0.97, math.log(0.25)
    note_slide(g, 0, 0.02)
    assert g.belief.doubted[0] == 1.0
    low = g.belief.mean[0]
    g.slip.sound[0], g.slip.silence[0], g.slip.slides[0] = sound, 0.6, 0.0
    note_slide(g, 0, 0.02)
    assert (g.belief.mean[0] == low) is stays
    assert (g.belief.mean[0] > low + 0.2) is not stays


def test_a_finger_in_the_air_neither_notices_a_slide_nor_misses_one() -> None:
    g = grasp()
    for i in range(2):
        hear_slip(g, i, DT, 0.0, math.nan)
    g.slip.sound[1], g.slip.silent[1] = 0.99, 0.005
    assert noticed(g) == pytest.approx(0.99)
    g.witness.forces[1] = 0.0
    assert noticed(g) == pytest.approx(0.48, abs=0.01)
    for _ in range(3):
        judge_slide(g, 0.2, 0.95)
    assert g.slip.sound[1] == pytest.approx(0.99)
    assert g.slip.sound[0] < 0.02


def test_a_load_that_is_not_known_at_all_leaves_no_trace() -> None:
    g = grasp()
    for _ in range(3):
        follow_utilisation(g, 0, DT, 0.3, math.inf, 0.0, True)
    assert follow_utilisation(g, 0, DT, 0.3, 0.02, 0.0, True) == pytest.approx(0.02)


def test_in_the_air_every_slip_is_a_lie() -> None:
    g = grasp()
    run(g, 0.1, lambda _: math.nan, ALWAYS)
    assert probabilities(g)[2] > SURE


def test_one_sample_is_not_believed() -> None:
    g = grasp()
    run(g, 1.0, rising(0.3, 1.0), QUIET)
    hear_slip(g, 0, 0.001, 1.0, math.nan)
    assert g.slip.slides[0] < 0.5
    hear_slip(g, 0, 0.001, 0.0, math.nan)
    assert g.slip.slides[0] == 0.0


def test_a_slide_that_no_channel_has_told_counts_against_all_and_one_that_one_has_told_against_none() -> None:
    missed, told = grasp(), grasp()
    for g in (missed, told):
        run(g, 1.0, rising(0.3, 1.0), QUIET, 0)
        run(g, 1.0, rising(0.3, 1.0), QUIET, 1)
    hear_slip(told, 1, DT, 1.0, math.nan)
    for g in (missed, told):
        judge_slide(g, 0.2, 0.95)
    assert missed.slip.sound[0] < 0.1
    assert missed.slip.silent[1] > 0.9
    assert told.slip.sound[0] == pytest.approx(0.48, abs=0.01)
    assert told.slip.silent[1] < 1e-3


def test_a_channel_that_is_not_sensed_says_nothing_and_is_not_named() -> None:
    g = grasp()
    run(g, 5.0, rising(0.3, 1.0), lambda _: math.nan)
    judge_slide(g, 0.2, 0.99)
    assert g.slip.sound[0] == pytest.approx(0.48, abs=0.01)
    assert sound_channel(g, 0) == noticed(g) == 0.0


def test_the_sign_of_a_speed_is_none_of_its_business_and_a_threshold_of_zero_switches_it_off() -> None:
    g = grasp()
    for speed, says in ((2e-3, 1.0), (1e-3, 1.0), (0.99e-3, 0.0), (0.0, 0.0)):
        hear_slip(g, 0, DT, 0.0, speed)
        assert g.slip.says[BELIEF_MOST] == says
    begin_channels(g, 0.0, DELAY)
    hear_slip(g, 0, DT, 0.0, 2e-3)
    assert math.isnan(g.slip.says[BELIEF_MOST])


def test_probabilities_stay_probabilities_whatever_is_said() -> None:
    g, rng = grasp(), np.random.default_rng(5)
    for _ in range(20_000):
        i, dt = int(rng.integers(2)), float(rng.choice([0.0, 1e-4, 2e-3, 0.1]))
        flag = float(rng.choice([0.0, 1.0, 0.5, math.nan, -3.0, math.inf]))
        speed = float(rng.choice([0.0, 1e-2, math.nan, math.inf]))
        hear_slip(g, i, dt, flag, speed)
        u = float(rng.choice([0.0, 0.3, 3.0, 1e-300, 1e300, math.nan, math.inf]))
        follow_utilisation(
            g, i, dt, u, float(rng.choice([0.0, 0.1, 5.0])), float(rng.uniform(-4.0, 3.0)), True
        )
        if rng.random() < 0.01:
            judge_slide(g, 0.1, float(rng.random()))
        for at in (0, 1, BELIEF_MOST, BELIEF_MOST + 1):
            sound, silent, lies = probabilities(g, at)
            assert min(sound, silent, lies) >= 0.0
            assert sound + silent <= 1.0 + 1e-12
        assert 0.0 <= g.slip.slides[i] <= 1.0


def test_what_has_held_stays_what_it_was_when_a_slide_teaches_the_exponent() -> None:
    g, load = grasp(), math.log(0.2 / 5.0)
    expect_exponent(g, 0.15, 0.12**2)
    begin_channels(g, 1e-3, DELAY)
    g.belief.load[0] = g.belief.load[1] = load
    for _ in range(100):
        follow_utilisation(g, 1, DT, 0.8, 0.02, load, True)
    absorb_slide(g, 0, math.log(2.9), 0.01)
    assert g.belief.mean[2] > 0.25  # it has taught the exponent
    refer_anew(g)
    assert g.slip.level[1] - g.belief.mean[2] * load == pytest.approx(math.log(0.8))
    assert g.slip.held[1] - g.belief.mean[2] * load == pytest.approx(math.log(0.8), abs=0.1)


def test_what_has_held_stays_what_it_was_when_a_slide_is_revoked_that_had_taught_the_exponent() -> None:
    g, load = grasp(), math.log(0.2 / 5.0)
    expect_exponent(g, 0.15, 0.12**2)
    begin_channels(g, 1e-3, DELAY)
    g.belief.load[0] = g.belief.load[1] = load
    absorb_hold(g, 1, math.log(0.8), 0.01)
    refer_anew(g)
    kept = g.belief.record[1]
    absorb_slide(g, 0, math.log(2.9), 0.01)
    refer_anew(g)
    assert g.belief.record[1] != pytest.approx(kept)  # as the slide has taught
    void_slides(g)
    refer_anew(g)
    assert g.belief.record[1] == pytest.approx(kept)
    assert g.belief.record[0] == -math.inf


@pytest.mark.parametrize("p", [0.02, 0.5, 0.95])
def test_one_that_has_told_of_a_slide_that_the_load_shows_is_as_likely_as_the_table_has_it(p: float) -> None:
    g = grasp()
    g.slip.silence[0], g.slip.says[0] = 0.2, 0.0
    judge_slide(g, 0.2, p)
    sound = USUAL * (p * DETECTS + (1.0 - p) * RARE)
    assert g.slip.sound[0] / faulty(g, 0) == pytest.approx(sound / (RARE * RARE), rel=1e-3)
    g.slip.silence[1] = 0.2001  # too long ago, and nobody else has told either
    g.slip.silence[0], g.slip.says[1] = math.inf, 0.0
    judge_slide(g, 0.2, p)
    assert g.slip.sound[1] / g.slip.silent[1] == pytest.approx(USUAL * (1.0 - p * DETECTS) / EVEN)
    assert g.slip.silent[1] / faulty(g, 1) == pytest.approx(EVEN / RARE)


EXPONENT, LOAD, WAS, HELD = 0.15, 0.7, math.log(0.3) + 0.105, math.log(0.4)


@pytest.mark.parametrize(
    ("u", "held", "shown", "begun", "slides", "told"),
    [
        (0.45, HELD, -math.inf, -math.inf, 0.0, False),
        (0.2, HELD, -math.inf, -math.inf, 0.0, False),
        (0.2, -0.1, -math.inf, HELD, 0.5, False),
        (0.2, -0.1, -math.inf, HELD, 0.49, True),
        (0.2, HELD, -math.inf, -0.1, 0.5, False),
        (3.0, HELD, -math.inf, -math.inf, 0.0, False),
        (0.45, HELD, -1.5, -math.inf, 0.49, False),
        (0.01, -0.1, -math.inf, -math.inf, 0.0, False),
    ],
    ids=["rises", "falls", "slides", "told lately", "held less", "far above", "shown", "far below"],
)
def test_a_finger_slides_by_its_load_as_the_belief_has_it_that_what_it_held_cuts_off(
    u: float, held: float, shown: float, begun: float, slides: float, told: bool
) -> None:
    """P(x < w + e | x > h - e), within what may have changed; the utilisation is averaged within a look."""
    g = grasp()
    expect_exponent(g, EXPONENT, 0.12**2)
    g.belief.load[0], g.slip.silence[1] = LOAD, 0.15 if told else 0.1501
    g.slip.level[0], g.slip.spread[0], g.slip.slides[0] = WAS, 0.01, slides
    g.slip.held[0], g.slip.shown[0], g.slip.begun[0] = held, shown, begun
    old, m = math.exp(-DT / LOOK), math.log(MU)
    mean = u + old * (0.3 - u)
    unsure = (0.03 * u + old * (0.01 - 0.03 * u)) / mean
    w, e = math.log(mean) + EXPONENT * LOAD, math.hypot(0.1, unsure)
    std = math.sqrt(0.35**2 + (0.12 * LOAD) ** 2 + 1e-6)
    h = held - DT / 10.0
    before = min(h, begun) if begun > -math.inf else h
    was = before if slides >= 0.5 else h
    above, lost = norm.sf([w + e, was - e], m, std)
    stays = [math.exp(-0.5 * max((one - w) / e, 0.0) ** 2) for one in (was, before)]
    changed = max(stays[0], norm.cdf(w + e, m, math.hypot(std, 0.4)))
    p = min(max(1.0 - above / lost, 0.02 * changed, 1e-4), 0.95)
    assert follow_utilisation(g, 0, DT, u, 0.03, LOAD, True) == pytest.approx(unsure)
    assert (g.slip.level[0], g.slip.top[0], g.slip.likely[0]) == pytest.approx((w, w, p), rel=1e-6)
    assert g.slip.stays[0] == pytest.approx(stays[told])
    rises = min(w - 2.0 * unsure, shown + 5.0 * DT if shown > -math.inf else math.inf, m + 2.0 * std)
    assert g.slip.held[0] == pytest.approx(max(h, rises))
    assert g.slip.shown[0] == pytest.approx(rises if slides < 0.5 else shown)


def test_all_that_was_seen_of_a_finger_is_referred_anew_by_its_load() -> None:
    g = grasp()
    seen = (g.slip.level, g.slip.held, g.slip.shown, g.slip.begun, g.slip.top, g.slip.top_next)
    for one in (*seen, g.belief.record):
        one[1] = -1.0
    g.belief.load[1], g.belief.site_load[1] = 0.7, -0.3
    g.belief.mean[2] = g.slip.exponent + 1.0
    for _ in range(2):
        refer_anew(g)
        assert [one[1] for one in (*seen, g.belief.record)] == pytest.approx([-0.3] * 6 + [-1.3])


@pytest.mark.parametrize(
    ("held", "stays", "expected"),
    [
        ((0.0, -1.0, -2.0), (0.9, 0.2, 0.3), 0.3),
        ((0.0, -1.0, -math.inf), (0.9, 0.2, 0.3), 0.2),
        ((0.0, -math.inf, -1.0), (0.9, 0.2, 0.0), 0.0),
        ((0.0, -math.inf, -math.inf), (0.9, 0.2, 0.3), 1.0),
    ],
)
def test_a_finger_of_which_too_little_is_known_may_slide_as_the_others_that_have_held(
    held: tuple[float, ...], stays: tuple[float, ...], expected: float
) -> None:
    g = grasp(3)
    for i in range(3):
        g.slip.held[i], g.slip.stays[i] = held[i], stays[i]
    assert others_stay(g, 0) == expected


def test_another_finger_that_slides_makes_a_slide_half_as_likely_as_its_own() -> None:
    g = grasp()
    g.slip.likely[0], g.slip.likely[1], g.slip.shows[1] = 0.1, 0.6, 2.0
    assert likely_slide(g, 0) == pytest.approx(0.5 / (1.0 + 0.4 / 0.6 * math.exp(-2.0)))
    g.slip.shows[1] = 0.0
    assert likely_slide(g, 0) == 0.1
