"""Felt slip is trusted once a channel was heard at a slide, and while the load shows none that it missed."""

import math

import numpy as np
import pytest

from vegrip.grip import slip_trust
from vegrip.grip.felt_slip import (
    FELT_BY_LOAD,
    FELT_DEAF,
    believed_flag,
    distrust,
    judge_felt_slip,
)
from vegrip.grip.felt_slip import begin_felt_slip as begin_felt
from vegrip.grip.friction_belief import (
    absorb_factor,
    begin_belief,
    believed_variance,
    expect_finger,
)
from vegrip.grip.friction_onset import begin_onsets
from vegrip.grip.friction_probe import begin_probing, feel_slip, watch_load
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.late_slip import begin_late_slip
from vegrip.grip.slip_trust import (
    begin_trust,
    counted_shift,
    counts_as_known,
    ends_probe,
    follow_trust,
    let_go,
    trusts_slip,
)

DT = 0.005
MU, LAG, NOISE = 0.6, 1.6, 0.002


class Grasp:
    """Two fingers that hold a load of 1 N, and what is known of slip."""

    def __init__(self) -> None:
        g = self.g = GraspMemory()
        begin_belief(g, 2, 0.0, 0.08)
        for i in range(2):
            expect_finger(g, i, math.log(0.7), 0.4, 0.08)
        begin_probing(g, 2.0, 0.6, 0.2, 0.06, 0.2, 0.05, 0.5, 2.0)
        begin_onsets(g, 0.1, 0.08)
        begin_felt(g, 1e-3, 0.02)
        begin_late_slip(g)
        begin_trust(g)
        self.tick = 0

    def let_go_of(self, shift: float = 0.5) -> None:
        for i in range(2):
            self.g.probe.shift[i] = shift

    def feel(self, force: float, pull: float, slip: float = 0.0, speed: float = math.nan) -> None:
        """Take a sample of both fingers, whose slip speed is noise where it is not given."""
        self.tick += 1
        said = 2e-5 * (self.tick % 3) if math.isnan(speed) else speed
        for i in range(2):
            u = pull / force
            flag = believed_flag(self.g, i, slip)
            watch_load(self.g, i, DT, pull, NOISE, True)
            feel_slip(self.g, DT, 2, slipping=False)
            follow_trust(self.g, i, DT, flag, said, u, 0.01, force, pull, NOISE, True)
            judge_felt_slip(self.g, i, DT, slip, said, u, 0.0)

    def hold(self, seconds: float) -> None:
        for _ in range(round(seconds / DT)):
            self.feel(4.0, 0.5)

    def prove(self) -> None:
        self.hold(1.0)
        self.let_go_of()
        self.feel(4.0, 0.5)
        self.feel(4.0, 0.5, slip=1.0)


def test_silence_proves_nothing_and_slip_that_is_expected_proves_a_flag_for_a_while() -> None:
    grasp = Grasp()
    grasp.hold(5.0)
    assert not trusts_slip(grasp.g)
    grasp.prove()
    assert trusts_slip(grasp.g)
    grasp.let_go_of(0.0)
    grasp.hold(59.9)
    assert trusts_slip(grasp.g)
    grasp.hold(0.2)
    assert not trusts_slip(grasp.g)


def test_slip_that_is_not_expected_or_was_not_silent_before_proves_nothing() -> None:
    held = Grasp()
    held.hold(1.0)
    held.feel(4.0, 0.5, slip=1.0)  # nothing was let go of
    talks = Grasp()
    talks.hold(1.0)
    talks.feel(4.0, 0.5, slip=1.0)
    talks.let_go_of()
    for _ in range(20):
        talks.feel(4.0, 0.5)
    talks.feel(4.0, 0.5, slip=1.0)  # 0.1 s after the last slip
    low = Grasp()
    low.hold(1.0)
    low.let_go_of()
    for _ in range(5):
        low.feel(4.0, 0.5)
    low.feel(8.0, 0.5, slip=1.0)  # far below what it has just held
    assert not any(trusts_slip(grasp.g) for grasp in (held, talks, low))


@pytest.mark.parametrize("mean", [math.log(0.5), math.log(1.2)])
def test_without_trust_no_finger_counts_on_more_than_the_prior_or_the_belief(mean: float) -> None:
    g = Grasp().g
    absorb_factor(g, 0, 100.0, 100.0 * mean)
    prior = math.log(0.7) - LAG * 0.4
    believed = g.belief.mean[0] - LAG * math.sqrt(believed_variance(g, 0))
    counted = believed + counted_shift(g, 0, LAG)
    assert counted == pytest.approx(min(prior, believed))
    assert not counts_as_known(g, 0)
    g.trust.proof[1] = 1.0  # a slide of the object is one of all fingers
    assert counted_shift(g, 0, LAG) == 0.0
    assert counts_as_known(g, 0)


def lower(grasp: Grasp, seconds: float) -> None:
    """Let N fall by 1 a second in ln N, from 1.8 N, while the contacts hold."""
    for k in range(round(seconds / DT)):
        grasp.feel(1.8 * math.exp(-k * DT), 0.5)


def slide_until_told(grasp: Grasp) -> tuple[float, float]:
    """Go on from the limit until the load ends the probe; return the time [s] and the load then [N]."""
    force, seen = 0.83, 0.0
    while grasp.g.probe.shift[0] > 0.0:
        force *= math.exp(-DT)
        grasp.feel(force, MU * force)
        seen += DT
    return seen, MU * force


def test_the_load_ends_a_probe_when_the_object_slides_and_not_while_it_holds() -> None:
    holds, slides = Grasp(), Grasp()
    for grasp in (holds, slides):
        grasp.prove()
        grasp.hold(0.5)
        grasp.let_go_of()
    lower(holds, 0.75)
    lower(slides, 0.75)  # to 0.85 N
    assert holds.g.probe.shift[0] == slides.g.probe.shift[0] == 0.5
    seen, _ = slide_until_told(slides)
    assert seen < 0.1
    assert slides.g.trust.held > 0.0
    assert not trusts_slip(slides.g)


@pytest.mark.parametrize(("comes_back", "deaf"), [(True, True), (False, False)])
def test_a_channel_that_does_not_tell_a_slide_is_deaf_if_the_load_comes_back_with_the_grip(
    comes_back: bool, deaf: bool
) -> None:
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    lower(grasp, 0.75)
    _, lost = slide_until_told(grasp)
    for _ in range(60):
        grasp.feel(2.0, 0.5 if comes_back else lost)
    why = grasp.g.felt.why[1]
    assert (why == FELT_DEAF) == deaf
    assert math.isnan(believed_flag(grasp.g, 1, 0.0)) == deaf
    assert trusts_slip(grasp.g) != deaf


def test_a_slide_that_begins_with_a_fall_of_friction_ends_the_probe_though_n_has_not_fallen() -> None:
    grasp = Grasp()
    grasp.hold(1.0)
    grasp.let_go_of()
    grasp.hold(0.3)
    for _ in range(10):
        grasp.feel(4.0, 0.92 * 0.5)
    assert grasp.g.probe.shift[0] == 0.0


def test_a_fall_of_friction_while_n_falls_quickly_is_seen_at_once() -> None:
    grasp = Grasp()
    grasp.hold(1.0)
    grasp.let_go_of()
    lower(grasp, 0.75)
    grasp.feel(0.85, 0.9 * 0.5)
    assert grasp.g.probe.shift[0] == 0.0


@pytest.mark.parametrize(("late", "deaf"), [(0, False), (10, True)], ids=["in time", "50 ms late"])
def test_a_channel_that_tells_a_torn_slide_when_the_grip_is_back_is_deaf(late: int, deaf: bool) -> None:
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    for k in range(60):
        slides = k < 4
        grasp.feel(4.0 if slides else 6.0, 0.92 * 0.5 if slides else 0.5, float(k - late in range(4)))
    assert (grasp.g.felt.why[0] == FELT_DEAF) == deaf


@pytest.mark.parametrize(
    ("fallen", "deaf"), [(0.45, True), (0.49, False), (0.3, False)], ids=["slides", "is back", "is gone"]
)
def test_a_load_that_comes_back_before_the_grip_or_falls_on_was_no_slide(fallen: float, deaf: bool) -> None:
    """The contact that slides carries 0.9 of what it held, until there is more normal force."""
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    for _ in range(4):
        grasp.feel(4.0, 0.46)
    for _ in range(6):
        grasp.feel(4.0, fallen)
    for _ in range(60):
        grasp.feel(6.0, 0.5)
    assert (grasp.g.felt.why[0] == FELT_DEAF) == deaf


def test_a_load_that_held_is_not_counted_twice() -> None:
    """What was let go of is what the load has shown to hold, and so is what the estimate learns of it."""
    grasp = Grasp()
    grasp.let_go_of()
    grasp.g.trust.kept[0] = 0.3
    before = grasp.g.belief.mean[0]
    absorb_factor(grasp.g, 0, 10.0, 10.0 * (before + 0.2))
    rise = grasp.g.belief.mean[0] - before
    grasp.feel(4.0, 0.5)
    assert rise > 0.05
    assert grasp.g.probe.shift[0] == pytest.approx(0.5 - rise)
    assert grasp.g.trust.kept[0] == pytest.approx(0.3 - rise)


def test_a_load_that_fades_and_comes_back_is_no_slide_that_the_channel_missed() -> None:
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    force, load = 1.8, 0.5
    while grasp.g.probe.shift[0] > 0.0:
        force, load = force * math.exp(-DT), load * math.exp(-0.5 * DT)
        grasp.feel(force, load)
    assert load > 0.3
    for _ in range(60):
        grasp.feel(2.0, 0.5)
    assert trusts_slip(grasp.g)


def test_a_slide_does_not_end_before_the_grip_is_back() -> None:
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    lower(grasp, 0.75)
    _, lost = slide_until_told(grasp)
    for _ in range(60):
        grasp.feel(lost / MU, 0.5)  # more than such a contact could hold
    assert grasp.g.felt.why[1] != FELT_DEAF


def test_while_slip_is_trusted_what_a_quick_fall_has_held_is_kept_until_a_finger_slips() -> None:
    for proven in (True, False):
        grasp = Grasp()
        if proven:
            grasp.prove()
        grasp.hold(0.5)
        grasp.let_go_of()
        lower(grasp, 0.3)
        for _ in range(80):
            grasp.feel(1.8 * math.exp(-0.3), 0.5)
        kept = 0.38 if proven else 0.0
        assert grasp.g.probe.shift[0] == grasp.g.trust.kept[0] == pytest.approx(kept)
        assert ends_probe(grasp.g, 0, DT, True, True)
        assert grasp.g.trust.kept[0] == 0.0


def test_friction_that_was_low_before_a_flag_lied_is_not_taken_for_usual() -> None:
    grasp = Grasp()
    absorb_factor(grasp.g, 0, 1000.0, 1000.0 * math.log(0.15))
    low = grasp.g.belief.mean[1]
    grasp.hold(2.1)
    distrust(grasp.g, 0, FELT_BY_LOAD, 30.0)
    grasp.feel(4.0, 0.5)
    assert grasp.g.belief.mean[1] == pytest.approx(low + 0.4)
    assert believed_variance(grasp.g, 1) == pytest.approx(0.16)


def test_an_object_that_is_not_known_is_let_go_of_until_it_slides_and_a_known_one_is_not() -> None:
    for std in (0.4, 0.1):
        grasp = Grasp()
        if std < 0.2:
            absorb_factor(grasp.g, 0, 1000.0, 1000.0 * math.log(0.7))
        grasp.hold(1.0)
        for i in range(2):
            grasp.g.trust.noisy[i] = 50.0
        for _ in range(400):
            let_go(grasp.g, 0, DT, LAG, 0.15, 100.0, NOISE, True, False)
        reach = grasp.g.belief.mean[0] + 2.0 * math.sqrt(believed_variance(grasp.g, 0))
        counted = math.log(0.7) - LAG * 0.4 + grasp.g.probe.shift[0]
        assert (counted > reach + 1e-9) == (std > 0.2)


def test_a_slip_speed_that_was_noisy_and_becomes_constant_or_vanishes_voids_the_proof() -> None:
    for speed in (0.0, 1e-3):
        grasp = Grasp()
        grasp.prove()
        grasp.let_go_of(0.3)
        for _ in range(42):
            grasp.feel(4.0, 0.5, speed=speed)
        assert not trusts_slip(grasp.g)
        assert grasp.g.probe.shift[0] == 0.0


def test_what_a_flag_has_taught_is_void_when_it_contradicts_the_load() -> None:
    grasp = Grasp()
    grasp.prove()
    absorb_factor(grasp.g, 0, 100.0, 100.0 * math.log(0.25))
    distrust(grasp.g, 0, FELT_BY_LOAD, 30.0)
    grasp.feel(4.0, 0.5)
    assert grasp.g.belief.mean[0] == pytest.approx(math.log(0.7))
    assert believed_variance(grasp.g, 0) == pytest.approx(0.16)


def test_slip_told_again_and_again_far_below_what_has_just_held_is_not_believed() -> None:
    grasp = Grasp()
    for _ in range(3):
        grasp.hold(0.5)
        grasp.feel(8.0, 0.5, slip=1.0)
    assert grasp.g.trust.false[0] > 0.0
    assert math.isnan(believed_flag(grasp.g, 0, 0.0))


def test_two_fingers_are_let_go_of_for_proof_only_where_their_slip_speed_shows_noise() -> None:
    for noisy in (0.0, 50.0):
        grasp = Grasp()
        grasp.hold(1.0)
        for i in range(2):
            grasp.g.trust.noisy[i] = noisy
        for _ in range(20):
            let_go(grasp.g, 0, DT, LAG, 0.15, 0.3, NOISE, True, False)
        assert (grasp.g.probe.shift[0] > 0.0) == (noisy > 0.0)


def test_a_load_that_is_lost_in_its_noise_is_not_let_go_of() -> None:
    grasp = Grasp()
    grasp.hold(1.0)
    loud = 0.075
    for _ in range(20):
        let_go(grasp.g, 0, DT, LAG, 0.15, 0.3, loud, True, False)
    assert grasp.g.probe.shift[0] == 0.0


def until(says, most: int = 10_000) -> int:
    """Return how often ``says`` is asked until it says yes."""
    return next(k for k in range(1, most) if says())


def test_a_slide_that_the_slip_speed_alone_tells_ends_a_probe_when_a_flag_would_be_late() -> None:
    q = Grasp().g  # whose slip channel is 20 ms late
    assert ends_probe(q, 1, 0.004, True, False)
    assert until(lambda: ends_probe(q, 1, 0.004, False, True)) == 13  # 50 ms
    assert not ends_probe(q, 1, 0.004, False, False)
    assert until(lambda: ends_probe(q, 1, 0.004, False, True)) == 13
    assert not ends_probe(q, 0, 0.004, False, True)


@pytest.mark.parametrize(
    ("fingers", "i", "noisy", "shifts", "seeks"),
    [
        (2, 1, 49.0, (0.0, 0.0, 0.0), False),
        (2, 0, 50.0, (0.0, 0.3, 0.0), True),
        (3, 0, 0.0, (0.0, 0.0, 0.0), False),
        (3, 1, 0.0, (0.0, 0.2, 0.0), True),
        (3, 1, 0.0, (0.0, 0.2, 0.1), False),
        (3, 1, 0.0, (0.1, 0.2, 0.0), False),
    ],
)
def test_a_finger_that_is_not_the_thumb_is_let_go_of_for_proof_alone(
    fingers: int, i: int, noisy: float, shifts: tuple[float, ...], seeks: bool
) -> None:
    q = GraspMemory()
    begin_belief(q, fingers, 0.0, 0.08)
    q.trust.noisy[i] = noisy
    for j in range(3):
        q.probe.shift[j] = shifts[j]
    assert slip_trust.seeks_proof(q, i) == seeks


def test_the_rise_that_noise_does_not_make_is_five_deviations_of_the_smoothed_sum() -> None:
    q, noise, rng = Grasp().g, 0.05, np.random.default_rng(2)
    q.trust.pull[0], q.trust.pull[1] = 0.6, 0.9
    keep = math.exp(-0.001 / 0.01)
    smooth = np.zeros((2, 2000))
    for _ in range(200):
        smooth = keep * smooth + (1.0 - keep) * noise * rng.standard_normal((2, 2000))
    expected = 5.0 * np.std(smooth.sum(axis=0)) / 1.5
    assert slip_trust.rise_of_slide(q, 0.001, noise) == pytest.approx(expected, rel=0.05)
    assert slip_trust.rise_of_slide(q, DT, 1e-9) == 0.03
    assert slip_trust.rise_of_slide(q, 0.0, noise) == math.inf
    q.trust.pull[0] = q.trust.pull[1] = 0.0
    assert slip_trust.rise_of_slide(q, DT, noise) == math.inf


def test_friction_has_torn_where_f_and_its_part_of_n_are_less_than_of_late_by_the_rise() -> None:
    q = Grasp().g
    q.trust.load = 2.0
    for pull, force, torn in (
        (0.099, 0.0, False),
        (0.101, 0.0, True),
        (0.101, -0.1, False),
        (0.099, 0.1, False),
    ):
        q.trust.ratio = 0.5
        assert slip_trust.has_torn(q, 2.0 * math.exp(-pull), 4.0 * math.exp(force), 1e-9, 0.1) == torn
    q.trust.ratio = 0.5
    for _ in range(100):
        slip_trust.has_torn(q, 0.8, 4.0, 0.0005, 0.1)  # 50 ms
    assert q.trust.ratio == pytest.approx(0.2 + 0.3 / math.e)


@pytest.mark.parametrize(("rate", "slow"), [(0.22, True), (0.28, False)])
def test_a_fall_of_less_than_a_quarter_a_second_shows_no_slide_in_time(rate: float, slow: bool) -> None:
    q, force = Grasp().g, 4.0
    q.trust.first = q.trust.later = force
    told = []
    while force > 4.0 * 0.955:
        force *= math.exp(-rate * DT)
        told.append(slip_trust.is_slow(q, force, DT))
    assert not any(told)  # not before it has fallen by a twentieth
    for _ in range(300):
        force *= math.exp(-rate * DT)
        told.append(slip_trust.is_slow(q, force, DT))
    assert told[-1] == slow


def test_what_a_fall_has_held_is_kept_but_for_a_part_and_never_less_than_before() -> None:
    q = Grasp().g
    q.trust.proof[0] = 1.0
    for shift, kept in ((0.5, 0.38), (0.3, 0.38), (0.7, 0.58)):
        q.probe.shift[0] = shift
        slip_trust.keep_held(q)
        assert q.trust.kept[0] == pytest.approx(kept)
    slip_trust.take_back(q)
    assert q.probe.shift[0] == q.trust.kept[0] == pytest.approx(0.58)
    q.trust.proof[0] = 0.0
    slip_trust.take_back(q)  # what is not trusted holds nothing
    assert q.probe.shift[0] == q.trust.kept[0] == 0.0


@pytest.mark.parametrize("finger", [0, 1])
def test_a_slide_that_no_channel_told_makes_all_deaf_for_longer_each_time(finger: int) -> None:
    """What was told up to a tenth of a second before the fall, and since, is told of it."""
    q = Grasp().g
    places = (0, 1, BELIEF_MOST, BELIEF_MOST + 1)
    q.trust.told[0] = q.trust.told[1] = 9.0
    q.trust.proof[0] = 1.0
    q.trust.told[finger] = 0.235
    slip_trust.judge_slide(q)
    assert (q.trust.missed, q.trust.proof[0], q.felt.off[0]) == (0.0, 1.0, 0.0)
    q.trust.told[finger] = 0.245
    for missed, lasts in ((1.0, 10.0), (2.0, 300.0), (3.0, 300.0)):
        slip_trust.judge_slide(q)
        assert (q.trust.missed, q.trust.proof[0]) == (missed, 0.0)
        assert [q.felt.off[at] for at in places] == [lasts] * 4
        assert [q.felt.why[at] for at in places] == [FELT_DEAF] * 4


@pytest.mark.parametrize(
    ("silent", "let", "u", "proves", "false"),
    [
        (0.51, 0.1, 0.72, True, 1.0),
        (0.51, 0.1, 0.81, True, 0.0),
        (0.49, 0.1, 0.81, False, 0.0),
        (0.51, 0.1, 0.69, False, 1.0),
        (0.51, 0.0011, 0.81, True, 0.0),
        (0.51, 0.0009, 0.81, False, 0.0),
        (0.0, 0.1, 0.69, False, 0.0),  # it has said so already
        (0.51, 0.1, 0.0, False, 0.0),  # not known
    ],
)
def test_a_flag_is_proven_by_slip_near_what_was_held_and_told_wrong_far_below(
    silent: float, let: float, u: float, proves: bool, false: float
) -> None:
    q = Grasp().g
    q.trust.top[1], q.probe.shift[1], q.trust.kept[1], q.trust.missed = 1.0, 0.4 + let, 0.4, 1.0
    q.felt.quiet[1] = silent
    slip_trust.hear_slide(q, 1, u)
    assert q.trust.proof[1] == (60.0 if proves else 0.0)
    assert q.trust.missed == (0.0 if proves else 1.0)
    assert q.trust.false[1] == false


@pytest.mark.parametrize(("before", "distrusted"), [(1.4, False), (1.6, True)])
def test_slip_that_is_told_far_below_what_was_held_more_than_twice_of_late_is_not_believed(
    before: float, distrusted: bool
) -> None:
    q = Grasp().g
    q.trust.top[0], q.trust.false[0], q.felt.quiet[0] = 1.0, before, 1.0
    slip_trust.hear_slide(q, 0, 0.5)
    assert (q.felt.off[0] > 0.0) == distrusted
    grasp = Grasp()
    grasp.feel(4.0, 2.0)
    grasp.g.trust.false[0] = 1.0
    for _ in range(200):
        grasp.feel(40.0, 0.5)
    assert grasp.g.trust.false[0] == pytest.approx(math.exp(-1.0 / 5.0))
    assert grasp.g.trust.top[0] == pytest.approx(0.5 * math.exp(-1.0))


def test_a_slip_speed_is_constant_after_forty_samples_and_noisy_after_fifty_changes() -> None:
    q = Grasp().g
    for k in range(50):
        assert q.trust.noisy[0] == k
        slip_trust.watch_constant(q, 0, 1e-5 * (k % 2 + 1))
    q.trust.proof[0] = 1.0
    same = until(lambda: slip_trust.watch_constant(q, 0, 2e-5) or q.trust.proof[0] == 0.0)
    assert same == 41
    assert q.trust.noisy[0] == 0.0
    q.trust.proof[0] = 1.0
    for _ in range(100):  # whose slip speed is no noise tells by its flag
        slip_trust.watch_constant(q, 0, math.nan)
    assert q.trust.proof[0] == 1.0


@pytest.mark.parametrize(
    ("u", "proven", "rate"), [(0.999, True, 2.0), (1.001, True, 2.0), (0.999, False, 5.0), (0.0, True, 0.0)]
)
def test_a_finger_is_let_go_of_no_farther_than_its_load_is_known_to_need(
    u: float, proven: bool, rate: float
) -> None:
    grasp = Grasp()
    grasp.hold(1.0)
    q = grasp.g
    q.trust.proof[0], q.trust.noisy[0] = float(proven), 50.0
    low = q.belief.mean[0] - LAG * math.sqrt(believed_variance(q, 0)) + math.log(0.8)
    ahead = math.exp(low - 1.7)  # of what it needs
    let_go(q, 0, DT, LAG, 0.2, u * ahead, NOISE, True, False)
    assert q.probe.shift[0] == pytest.approx(rate * DT if u > 1.0 else 0.0)
    let_go(q, 0, DT, LAG, 0.2, 2.0 * u * ahead, NOISE, True, True)
    let_go(q, 0, DT, LAG, 0.2, 2.0 * u * ahead, NOISE, False, False)
    shift = q.probe.shift[0]
    let_go(q, 0, DT, LAG, 0.2, 2.0 * u * ahead, NOISE, True, False)
    assert q.probe.shift[0] - shift == pytest.approx(rate * DT)


@pytest.mark.parametrize(
    ("grip", "pull", "missed"),
    [
        (1.16, 0.81, True),
        (1.14, 0.81, False),
        (1.16, 0.79, False),
    ],
)
def test_a_slide_is_judged_when_grip_and_load_are_back(grip: float, pull: float, missed: bool) -> None:
    """At 1.15 times the force at which it began, and with six tenths of what was lost of the load."""
    grasp = Grasp()
    grasp.prove()
    grasp.hold(1.0)
    q = grasp.g
    for _ in range(40):
        grasp.feel(grip, 0.5 * pull)
    q.trust.grip, q.trust.load, q.trust.fell, q.trust.wait = 2.0, 1.0, 0.5, 0.14
    q.trust.torn = 0.5 * pull / grip
    seen = until(lambda: grasp.feel(grip, 0.5 * pull) or q.trust.wait <= 0.0)
    for _ in range(20):
        grasp.feel(grip, 0.5 * pull)
    assert (q.trust.missed == 1.0) == missed
    assert seen == pytest.approx(
        10 if grip > 1.15 else 28, abs=1
    )  # 50 ms after the grip is back, or never before 140 ms
