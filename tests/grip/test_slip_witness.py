"""While an object holds, T stays as N is let go of; while it slides, T = mu N."""

import math

import numpy as np
import pytest

from vegrip.grip import slip_witness
from vegrip.grip.friction_belief import begin_belief, expect_finger
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.slip_channels import begin_channels, follow_utilisation, hear_slip
from vegrip.grip.slip_witness import (
    BLIND,
    begin_witness,
    follow_forces,
    is_slow,
    rise_needed,
    sees_slide,
    wait_for_verdict,
    watch_part,
)

DT, NOISE, MU, LOAD = 0.002, 0.01, 0.5, 1.0


def grasp() -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, 2, 0.03)
    for i in range(2):
        expect_finger(g, i, math.log(MU), 0.35, 0.08)
    begin_channels(g, 1e-3, 0.0)
    begin_witness(g, NOISE)
    return g


def let_go(g: GraspMemory, rate: float, seconds: float, load: float = LOAD, fade: float = 0.0) -> float:
    """Let N fall from 4 N at ``rate`` [1/s]; return N over the least when a slide is seen; NaN: never.

    ``fade`` [1/s] is the rate at which the load goes away.
    """
    rng = np.random.default_rng(1)
    for k in range(round(seconds / DT)):
        t = k * DT
        force = 4.0 * math.exp(-rate * t)
        weight = load * math.exp(-fade * t)
        pull = min(0.5 * weight, MU * force)
        for i in range(2):
            hear_slip(g, i, DT, 0.0, math.nan)
            follow_utilisation(g, i, DT, pull / force, 0.02, 0.0, True)
            follow_forces(g, i, DT, force, pull + NOISE * rng.standard_normal(), True)
        if sees_slide(g, 2.0 * DT, 0.5, False):
            return force / (0.5 * load / MU)
    return math.nan


@pytest.mark.parametrize("rate", [1.0, 3.0, 6.0])
def test_a_slide_shows_before_n_is_a_tenth_below_the_least(rate: float) -> None:
    assert 0.85 < let_go(grasp(), rate, 4.0 / rate) < 1.0


def test_an_object_that_holds_shows_no_slide() -> None:
    assert math.isnan(let_go(grasp(), 1.0, 1.3))


def test_a_load_that_goes_away_faster_than_n_is_no_slide() -> None:
    assert math.isnan(let_go(grasp(), 0.5, 1.0, fade=2.0))


def test_without_anything_let_go_of_nothing_is_seen() -> None:
    g = grasp()
    for k in range(500):
        for i in range(2):
            follow_forces(g, i, DT, 4.0 - 0.006 * k, 2.0 - 0.003 * k, True)
        assert not sees_slide(g, 2.0 * DT, 0.0, False)


@pytest.mark.parametrize(("comes_back", "named"), [(True, True), (False, False)])
def test_a_slide_was_missed_if_t_comes_back_with_n_and_not_else(comes_back: bool, named: bool) -> None:
    g = grasp()
    assert let_go(g, 4.0, 1.5) < 1.0
    silent = g.slip.silent[0]
    for _ in range(120):
        for i in range(2):
            hear_slip(g, i, DT, 0.0, math.nan)
            follow_forces(g, i, DT, 3.0, 0.5 if comes_back else 0.4, True)
        sees_slide(g, 2.0 * DT, 0.0, False)
        pull = g.witness.pulls[0] + g.witness.pulls[1]
        lost = max(min(math.log(pull / g.witness.pull), 0.0), -0.15) if g.witness.waits > 0.0 else 0.0
        assert g.witness.lack == pytest.approx(lost)  # until then the load counts as it was
    assert (g.slip.silent[0] > silent + 0.2) == named
    assert g.witness.waits == 0.0


@pytest.mark.parametrize("moves", ["lets go", "touches"])
def test_a_finger_that_comes_or_goes_is_no_slide_that_was_missed(moves: str) -> None:
    """The sums are of other fingers then: T falls as one lets go, and is back when it touches again."""
    g = grasp()
    before = list(g.slip.sound[:2])
    for k in range(400):
        t = k * DT
        is_away = 0.1 < t < 0.15 if moves == "lets go" else t < 0.1 or t > 0.3
        for i in range(2):
            touches = not (is_away and i == 1)
            hear_slip(g, i, DT, 0.0, math.nan)
            follow_forces(g, i, DT, 4.0 * math.exp(-t), 0.5, touches)
            sees_slide(g, DT, 0.5 if t < 0.2 else 0.0, False)
    assert g.witness.waits == 0.0
    assert list(g.slip.sound[:2]) == pytest.approx(before, abs=0.01)


def test_noise_that_hides_a_slide_is_known() -> None:
    g = grasp()
    for i in range(2):
        follow_forces(g, i, DT, 1.0, 0.02, True)
    assert rise_needed(g, DT) > BLIND
    for i in range(2):
        follow_forces(g, i, DT, math.nan, 0.02, False)
    assert rise_needed(g, DT) == math.inf


@pytest.mark.parametrize(
    ("pull", "rate", "is_told"),
    [(1.0, 0.5, True), (1.0, 0.7, False), (0.3, 1.2, True), (0.3, 3.0, False), (0.02, 3.0, True)],
)
def test_a_fall_in_which_the_object_slides_by_a_tenth_of_a_millimetre_unseen_is_no_witness(
    pull: float, rate: float, *, is_told: bool
) -> None:
    """Solved step by step: from when a slide begins until what is missing of the weight can be seen."""
    g = grasp()
    for i in range(2):
        follow_forces(g, i, DT, 4.0, pull, True)
    g.witness.first = g.witness.lagging = 4.0
    told = [is_slow(g, DT, 4.0 * math.exp(-rate * k * DT)) for k in range(round(1.0 / rate / DT))]
    assert not told[0]
    assert told[-1] == is_told
    speed = distance = missing = 0.0
    while 0.7 * missing < rise_needed(g, 2.0 * DT):
        missing += 1e-5 * rate
        speed += 1e-5 * 9.81 * missing
        distance += 1e-5 * speed
    assert (distance > 1.1e-4) == is_told


@pytest.mark.parametrize(
    ("falls", "has_changed", "is_asked"),
    [(0.04, True, True), (0.04, False, False), (0.16, True, False), (-0.04, True, False)],
    ids=["with N", "no change of the load", "by itself", "rises"],
)
def test_a_load_that_has_changed_with_n_counts_as_it_was_until_it_comes_back(
    falls: float, has_changed: bool, is_asked: bool
) -> None:
    """N has fallen by 6 %, and T by so much; no channel is judged by it."""
    g = grasp()
    for k, (force, pull) in enumerate([(2.0, 0.5), (2.0, 0.5), (2.0 * 0.94, 0.5 * (1.0 - falls))]):
        for i in range(2):
            g.witness.forces[i], g.witness.pulls[i] = force, pull
        assert not sees_slide(g, 2.0 * DT, 0.5, has_changed and k == 2)
    assert (g.witness.waits > 0.0) == is_asked
    sound, pull = g.slip.sound[0], 2.0 * g.witness.pulls[0]
    for _ in range(100):
        assert not sees_slide(g, 2.0 * DT, 0.0, False)
        lost = max(min(math.log(pull / g.witness.pull), 0.0), -0.15) if g.witness.waits > 0.0 else 0.0
        assert g.witness.lack == pytest.approx(lost)
        g.witness.pulls[0] = g.witness.pulls[1] = 0.5
        pull = 1.0
    assert g.slip.sound[0] == sound


def test_a_finger_that_is_lost_while_a_slide_is_judged_asks_for_a_sixth_more_at_most() -> None:
    """Its load is not gone: nothing is felt of it."""
    g = grasp()
    assert let_go(g, 4.0, 1.5) < 1.0
    for _ in range(10):
        for i in range(2):
            follow_forces(g, i, DT, math.nan, math.nan, True)
        sees_slide(g, 2.0 * DT, 0.0, False)
    assert g.witness.lack == -BLIND


@pytest.mark.parametrize("dt", [0.002, 0.03])
@pytest.mark.parametrize("pull", [0.1, 0.5, 4.0])
def test_a_rise_is_none_below_five_deviations_of_averaged_noise(pull: float, dt: float) -> None:
    """Of both fingers together, and of one by itself."""
    g = grasp()
    part = dt / (dt + 0.02)
    for i in range(2):
        g.witness.forces[i], g.witness.pulls[i] = 2.0, 0.5 * pull
    assert rise_needed(g, dt) == pytest.approx(max(0.02, 5.0 * NOISE * math.sqrt(2.0 * part) / pull))
    g.witness.pulls[1] = pull
    for lowered in (0.0, 0.1):
        watch_part(g, 1, dt, lowered)
    needed = max(0.02, 5.0 * NOISE * math.sqrt(part) / pull)
    for times, slid in ((0.99, 0.0), (1.01, 1.0)):
        g.witness.forces[1] = 2.0 * math.exp(times * needed / 0.3)
        watch_part(g, 1, dt, 0.1)
        assert g.witness.slid[1] == slid
    watch_part(g, 1, dt, 0.0)  # nothing is let go of any more
    assert (g.witness.part[1], g.witness.slid[1]) == (math.inf, 0.0)


@pytest.mark.parametrize(("falls", "seen"), [(0.16, True), (0.19, True), (0.21, False)])
def test_a_slide_is_as_likely_as_the_fingers_make_it_and_waited_for(falls: float, seen: bool) -> None:
    """N has fallen by e^-0.1, and T by so much; one that falls more than twice as fast goes away."""
    g = grasp()
    g.slip.delay, g.slip.likely[0], g.slip.likely[1], g.witness.rested = 0.02, 0.1, 0.3, 1.0
    for k in range(2):
        for i in range(2):
            g.witness.forces[i], g.witness.pulls[i] = 2.0 * math.exp(-0.1 * k), 0.5 * math.exp(-falls * k)
        assert sees_slide(g, 2.0 * DT, 0.5, False) == (seen and k == 1)
    if seen:
        pull = math.exp(-falls)
        assert g.witness.chance == pytest.approx(1.0 / (1.0 + 0.7 / 0.3 * 0.05 / 0.95))
        assert (g.witness.waits, g.witness.rested) == (pytest.approx(0.17), 0.0)
        told = g.witness.lost, g.witness.low, g.witness.high
        assert told == pytest.approx((1.0 - pull, pull, pull))
    assert g.witness.least == math.inf


@pytest.mark.parametrize(("back", "judged"), [(0.86, True), (0.84, False)])
def test_a_load_that_is_back_by_half_shows_a_slide_of_then(
    monkeypatch: pytest.MonkeyPatch, back: float, judged: bool
) -> None:
    """It had lost 0.2 N, and fell from 0.8 N to 0.75 N after that."""
    g, told = grasp(), []
    monkeypatch.setattr(slip_witness, "judge_slide", lambda _, *given: told.append(given))
    g.slip.delay, g.witness.waits, g.witness.chance, g.witness.lost = 0.02, 0.17, 0.6, 0.2
    g.witness.low = g.witness.high = 0.8
    g.witness.pull = 1.0
    for pull in (0.9, 0.75, back, 0.8):
        wait_for_verdict(g, 0.05, pull)
        assert g.witness.lack == (0.0 if pull == 0.8 else pytest.approx(max(math.log(pull), -BLIND)))
    assert told == [(pytest.approx(0.2 + 2.0 * 0.02), 0.6)] * judged
