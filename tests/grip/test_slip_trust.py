"""Felt slip is trusted once a channel was heard at a slide, and while the load shows none that it missed."""

import math

import pytest

from vegrip.grip.felt_slip import (
    FELT_BY_LOAD,
    FELT_DEAF,
    FELT_FLAG,
    FELT_WHY,
    FELT_WIDTH,
    believed_flag,
    distrust,
    judge_felt_slip,
)
from vegrip.grip.felt_slip import begin_felt_slip as begin_felt
from vegrip.grip.friction_belief import (
    BELIEF_MEAN,
    absorb_factor,
    begin_belief,
    believed_variance,
    expect_finger,
)
from vegrip.grip.friction_onset import begin_onsets
from vegrip.grip.friction_probe import PROBE_SHIFT, begin_probing, feel_slip, watch_load
from vegrip.grip.late_slip import begin_late_slip
from vegrip.grip.slip_trust import (
    TRUST_BLIND,
    TRUST_CLEAN_TIME,
    TRUST_FALSE,
    TRUST_HELD,
    TRUST_KEPT,
    TRUST_LASTS,
    TRUST_LIVELY,
    TRUST_NOISY,
    TRUST_PROOF,
    TRUST_RETREAT,
    TRUST_SIZE,
    TRUST_STILL,
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
        g = self.g = [0.0] * TRUST_SIZE
        begin_belief(g, 2, 0.0, 0.08)
        for i in range(2):
            expect_finger(g, i, math.log(0.7), 0.4, 0.08)
        begin_probing(g, 2.0, 0.6, 0.2, 0.06, 0.2, 0.05, 0.5, 2.0)
        begin_onsets(g, 0.1, 0.08)
        begin_felt(g, 1e-3, 0.02)
        begin_late_slip(g)
        begin_trust(g, g)
        self.tick = 0

    def let_go_of(self, shift: float = 0.5) -> None:
        for i in range(2):
            self.g[PROBE_SHIFT + i] = shift

    def feel(self, force: float, pull: float, slip: float = 0.0, speed: float = math.nan) -> None:
        """Take a sample of both fingers, whose slip speed is noise where it is not given."""
        self.tick += 1
        said = 2e-5 * (self.tick % 3) if math.isnan(speed) else speed
        for i in range(2):
            u = pull / force
            flag = believed_flag(self.g, i, slip)
            watch_load(self.g, i, DT, pull, NOISE, True)
            feel_slip(self.g, DT, 2, slipping=False)
            follow_trust(self.g, self.g, i, DT, flag, said, u, 0.01, force, pull, NOISE, True)
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
    assert not trusts_slip(grasp.g, grasp.g)
    grasp.prove()
    assert trusts_slip(grasp.g, grasp.g)
    grasp.let_go_of(0.0)
    grasp.hold(TRUST_LASTS - 0.1)
    assert trusts_slip(grasp.g, grasp.g)
    grasp.hold(0.2)
    assert not trusts_slip(grasp.g, grasp.g)


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
    assert not any(trusts_slip(grasp.g, grasp.g) for grasp in (held, talks, low))


@pytest.mark.parametrize("mean", [math.log(0.5), math.log(1.2)])
def test_without_trust_no_finger_counts_on_more_than_the_prior_or_the_belief(mean: float) -> None:
    g = Grasp().g
    absorb_factor(g, 0, 100.0, 100.0 * mean)
    prior = math.log(0.7) - LAG * 0.4
    believed = g[BELIEF_MEAN] - LAG * math.sqrt(believed_variance(g, 0))
    counted = believed + counted_shift(g, g, 0, LAG)
    assert counted == pytest.approx(min(prior, believed))
    assert not counts_as_known(g, g, 0)
    g[TRUST_PROOF + 1] = 1.0  # a slide of the object is one of all fingers
    assert counted_shift(g, g, 0, LAG) == 0.0
    assert counts_as_known(g, g, 0)


def lower(grasp: Grasp, seconds: float) -> None:
    """Let N fall by 1 a second in ln N, from 1.8 N, while the contacts hold."""
    for k in range(round(seconds / DT)):
        grasp.feel(1.8 * math.exp(-k * DT), 0.5)


def slide_until_told(grasp: Grasp) -> tuple[float, float]:
    """Go on from the limit until the load ends the probe; return the time [s] and the load then [N]."""
    force, seen = 0.83, 0.0
    while grasp.g[PROBE_SHIFT] > 0.0:
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
    assert holds.g[PROBE_SHIFT] == slides.g[PROBE_SHIFT] == 0.5
    seen, _ = slide_until_told(slides)
    assert seen < 0.1
    assert slides.g[TRUST_HELD] > 0.0
    assert not trusts_slip(slides.g, slides.g)


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
    why = grasp.g[FELT_FLAG + FELT_WIDTH + FELT_WHY]
    assert (why == FELT_DEAF) == deaf
    assert math.isnan(believed_flag(grasp.g, 1, 0.0)) == deaf
    assert trusts_slip(grasp.g, grasp.g) != deaf


def test_a_slide_that_begins_with_a_fall_of_friction_ends_the_probe_though_n_has_not_fallen() -> None:
    grasp = Grasp()
    grasp.hold(1.0)
    grasp.let_go_of()
    grasp.hold(0.3)
    for _ in range(10):
        grasp.feel(4.0, 0.92 * 0.5)
    assert grasp.g[PROBE_SHIFT] == 0.0


def test_a_load_that_fades_and_comes_back_is_no_slide_that_the_channel_missed() -> None:
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    force, load = 1.8, 0.5
    while grasp.g[PROBE_SHIFT] > 0.0:
        force, load = force * math.exp(-DT), load * math.exp(-0.5 * DT)
        grasp.feel(force, load)
    assert load > 0.3
    for _ in range(60):
        grasp.feel(2.0, 0.5)
    assert trusts_slip(grasp.g, grasp.g)


def test_a_slide_does_not_end_before_the_grip_is_back() -> None:
    grasp = Grasp()
    grasp.prove()
    grasp.hold(0.5)
    grasp.let_go_of()
    lower(grasp, 0.75)
    _, lost = slide_until_told(grasp)
    for _ in range(60):
        grasp.feel(lost / MU, 0.5)  # more than such a contact could hold
    assert grasp.g[FELT_FLAG + FELT_WIDTH + FELT_WHY] != FELT_DEAF


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
        kept = 0.5 - TRUST_RETREAT if proven else 0.0
        assert grasp.g[PROBE_SHIFT] == grasp.g[TRUST_KEPT] == pytest.approx(kept)
        assert ends_probe(grasp.g, 0, DT, True, True)
        assert grasp.g[TRUST_KEPT] == 0.0


def test_friction_that_was_low_before_a_flag_lied_is_not_taken_for_usual() -> None:
    grasp = Grasp()
    absorb_factor(grasp.g, 0, 1000.0, 1000.0 * math.log(0.15))
    low = grasp.g[BELIEF_MEAN + 1]
    grasp.hold(TRUST_CLEAN_TIME + 0.1)
    distrust(grasp.g, FELT_FLAG, FELT_BY_LOAD, 30.0)
    grasp.feel(4.0, 0.5)
    assert grasp.g[BELIEF_MEAN + 1] == pytest.approx(low + 0.4)
    assert believed_variance(grasp.g, 1) == pytest.approx(0.16)


def test_an_object_that_is_not_known_is_let_go_of_until_it_slides_and_a_known_one_is_not() -> None:
    for std in (0.4, 0.1):
        grasp = Grasp()
        if std < 0.2:
            absorb_factor(grasp.g, 0, 1000.0, 1000.0 * math.log(0.7))
        grasp.hold(1.0)
        for i in range(2):
            grasp.g[TRUST_NOISY + i] = TRUST_LIVELY
        for _ in range(400):
            let_go(grasp.g, grasp.g, 0, DT, LAG, 0.15, 100.0, NOISE, True, False)
        reach = grasp.g[BELIEF_MEAN] + 2.0 * math.sqrt(believed_variance(grasp.g, 0))
        counted = math.log(0.7) - LAG * 0.4 + grasp.g[PROBE_SHIFT]
        assert (counted > reach + 1e-9) == (std > 0.2)


def test_a_slip_speed_that_was_noisy_and_becomes_constant_or_vanishes_voids_the_proof() -> None:
    for speed in (0.0, 1e-3):
        grasp = Grasp()
        grasp.prove()
        grasp.let_go_of(0.3)
        for _ in range(int(TRUST_STILL) + 2):
            grasp.feel(4.0, 0.5, speed=speed)
        assert not trusts_slip(grasp.g, grasp.g)
        assert grasp.g[PROBE_SHIFT] == 0.0


def test_what_a_flag_has_taught_is_void_when_it_contradicts_the_load() -> None:
    grasp = Grasp()
    grasp.prove()
    absorb_factor(grasp.g, 0, 100.0, 100.0 * math.log(0.25))
    distrust(grasp.g, FELT_FLAG, FELT_BY_LOAD, 30.0)
    grasp.feel(4.0, 0.5)
    assert grasp.g[BELIEF_MEAN] == pytest.approx(math.log(0.7))
    assert believed_variance(grasp.g, 0) == pytest.approx(0.16)


def test_slip_told_again_and_again_far_below_what_has_just_held_is_not_believed() -> None:
    grasp = Grasp()
    for _ in range(3):
        grasp.hold(0.5)
        grasp.feel(8.0, 0.5, slip=1.0)
    assert grasp.g[TRUST_FALSE] > 0.0
    assert math.isnan(believed_flag(grasp.g, 0, 0.0))


def test_two_fingers_are_let_go_of_for_proof_only_where_their_slip_speed_shows_noise() -> None:
    for noisy in (0.0, TRUST_LIVELY):
        grasp = Grasp()
        grasp.hold(1.0)
        for i in range(2):
            grasp.g[TRUST_NOISY + i] = noisy
        for _ in range(20):
            let_go(grasp.g, grasp.g, 0, DT, LAG, 0.15, 0.3, NOISE, True, False)
        assert (grasp.g[PROBE_SHIFT] > 0.0) == (noisy > 0.0)


def test_a_load_that_is_lost_in_its_noise_is_not_let_go_of() -> None:
    grasp = Grasp()
    grasp.hold(1.0)
    loud = 0.5 * TRUST_BLIND
    for _ in range(20):
        let_go(grasp.g, grasp.g, 0, DT, LAG, 0.15, 0.3, loud, True, False)
    assert grasp.g[PROBE_SHIFT] == 0.0
