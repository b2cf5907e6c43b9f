"""The beginning of slip teaches once, within bounds, and not when it contradicts the load."""

import math

import pytest

from vegrip.grip.friction_belief import (
    absorb_factor,
    begin_belief,
    believed_variance,
    expect_finger,
)
from vegrip.grip.friction_onset import (
    begin_onsets,
    feel_onset,
    has_taught,
    is_doubted,
    is_heard,
)
from vegrip.grip.friction_probe import (
    begin_probing,
    feel_slip,
    probe_friction,
    watch_load,
)
from vegrip.grip.grasp_memory import GraspMemory

LN_MU, DT = math.log(0.7), 0.002


def grasp(fingers: int = 2, std: float = 0.3) -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, fingers, 0.03, 0.08)
    for i in range(fingers):
        expect_finger(g, i, LN_MU, std, 0.08)
    begin_probing(g, 1.5, 0.6, 0.2, 0.06, 0.2, 0.05, 0.5, 2.0)
    begin_onsets(g, 0.05, 0.08)
    return g


def feel(
    g: GraspMemory,
    u: float,
    slips: list[float],
    relative: float = 0.02,
    finger: int = 0,
    speed: float = math.nan,
) -> float:
    """Feel ``slips`` at the utilisation ``u``; return the mean of ln mu then."""
    for slip in slips:
        feel_onset(g, finger, DT, u, relative, slip, speed)
    return g.belief.mean[finger]


def test_an_onset_teaches_all_fingers_towards_the_load_at_which_it_began() -> None:
    g = grasp()
    g.probe.shift[0] = 0.3
    feel(g, 0.4, [0.0] * 50 + [1.0] * 3)
    assert math.exp(g.belief.mean[0]) == pytest.approx(0.4, rel=0.05)
    assert math.exp(g.belief.mean[1]) == pytest.approx(0.4, rel=0.1)


@pytest.mark.parametrize(
    ("slips", "relative", "u"),
    [([1.0], 0.02, 0.4), ([1.0, 0.0, 1.0, 0.0], 0.02, 0.4), ([1.0] * 9, 0.2, 0.4),
     ([1.0] * 9, 0.02, math.nan), ([math.nan] * 9, 0.02, 0.4)],
    ids=["one sample", "flicker", "light touch", "no load", "no channel"],
)  # fmt: skip
def test_what_may_be_nothing_teaches_nothing(slips: list[float], relative: float, u: float) -> None:
    g = grasp()
    assert feel(g, u, [0.0] * 50 + slips, relative) == LN_MU


def test_an_onset_below_what_has_just_held_teaches_nothing_in_any_way() -> None:
    """A channel that is late tells a slide when the grip is back."""
    g = grasp()
    feel(g, 0.6, [0.0] * 50)
    assert feel(g, 0.45, [0.0] * 5 + [1.0] * 3) == LN_MU
    assert has_taught(g, 0)


def test_where_slip_is_expected_one_sample_of_it_is_an_onset() -> None:
    """A probe ends in slip, which is over at once because the force comes back."""
    g = grasp()
    g.probe.shift[0] = 0.3
    assert feel(g, 0.9, [0.0] * 50 + [1.0]) == pytest.approx(math.log(0.9), abs=0.03)
    assert believed_variance(g, 0) < 0.2**2


def test_one_sample_of_slip_far_below_what_is_believed_teaches_nothing_in_a_probe_either() -> None:
    g = grasp()
    g.probe.shift[0] = 0.3
    assert feel(g, 0.4, [0.0] * 50 + [1.0]) == LN_MU


def test_a_channel_that_always_says_slip_teaches_at_most_once() -> None:
    g = grasp()
    once = feel(g, 0.5, [1.0] * 3)
    assert feel(g, 0.3, [1.0] * 5000) == once


def test_slip_without_slip_speed_is_no_onset() -> None:
    g = grasp()
    assert feel(g, 0.4, [0.0] * 50 + [1.0] * 9, speed=2e-5) == LN_MU
    assert feel(g, 0.4, [0.0] * 50 + [1.0] * 9, speed=1e-3) < LN_MU - 0.3


def creep(speeds: list[float]) -> float:
    """Feel slip at the speeds one after the other; return the mean of ln mu then."""
    g = grasp()
    feel(g, 0.4, [0.0] * 50)
    for speed in speeds:
        feel(g, 0.4, [1.0], speed=speed)
    return g.belief.mean[0]


def test_a_slide_that_begins_slowly_is_an_onset_when_its_speed_shows() -> None:
    assert creep([5e-5, 9e-5, 2e-4, 8e-5, 3e-4]) == creep([1e-3] * 2) < LN_MU - 0.3


def test_a_speed_that_shows_long_after_its_flag_is_no_onset() -> None:
    assert creep([5e-5] * 40 + [1e-3] * 9) == LN_MU


def test_one_sample_of_slip_is_an_onset_where_another_finger_has_just_slipped() -> None:
    g = grasp(3)
    for finger in range(3):
        feel(g, 0.4, [0.0] * 50, finger=finger)
    feel(g, 0.4, [1.0], finger=1)
    assert feel(g, 0.4, [1.0], finger=2) < LN_MU - 0.3


def test_fingers_that_slip_long_after_one_another_do_not_confirm_each_other() -> None:
    g = grasp()
    for slips in ([0.0] * 50 + [1.0] + [0.0] * 60, [0.0] * 60):
        feel(g, 0.4, slips, finger=1)
    assert feel(g, 0.4, [0.0] * 50 + [1.0]) == LN_MU


def test_an_onset_moves_the_belief_by_no_more_than_its_bound() -> None:
    for u in (1e-3, 1e3):
        g = grasp()
        moved = feel(g, u, [0.0] * 50 + [1.0] * 3) - LN_MU
        assert abs(moved) < 2.5 * math.hypot(0.31, 0.06)


def test_a_channel_that_contradicts_the_load_again_and_again_is_not_believed_any_more() -> None:
    g = grasp()
    for _ in range(3):
        feel(g, 0.6, [0.0] * 50)
        assert feel(g, 0.2, [1.0] * 3) == LN_MU
    assert is_doubted(g, 0)
    assert not is_heard(g, 0)
    feel(g, 0.6, [0.0] * 500)
    assert feel(g, 0.55, [1.0] * 3) == LN_MU


def hold(g: GraspMemory, seconds: float, load: float = 2.0) -> None:
    """Hold a load without slip, both fingers in turn."""
    for _ in range(round(seconds / DT)):
        for i in (0, 1):
            feel_onset(g, i, DT, 0.3, 0.02, 0.0, math.nan)
            watch_load(g, i, DT, load, 0.01, touching=True)
            feel_slip(g, DT, 2, slipping=False)
            g.probe.need[i] = 1.0
            probe_friction(g, i, DT, 0.7)


def test_probing_begins_when_nothing_happens_and_ends_at_once_with_a_slip() -> None:
    g = grasp()
    hold(g, 0.4)
    assert g.probe.shift[0] == 0.0  # too early
    hold(g, 0.4)
    assert g.probe.shift[0] > 0.2
    assert g.probe.shift[1] == pytest.approx(g.probe.shift[0], abs=0.01)
    feel_slip(g, DT, 2, slipping=True)
    assert g.probe.shift[0] == g.probe.shift[1] == 0.0
    hold(g, 0.4)
    assert g.probe.shift[0] == 0.0


def test_a_load_that_changes_stops_the_probing_of_every_finger() -> None:
    g = grasp()
    hold(g, 0.8)
    shift = g.probe.shift[0]
    for k in range(100):
        watch_load(g, 1, DT, 2.0 + 0.02 * k, 0.01, touching=True)
        probe_friction(g, 0, DT, 0.7)
    assert g.probe.shift[0] <= shift + 1.5 * 20 * DT


def test_probing_ends_where_friction_is_known_or_improbable() -> None:
    g = grasp()
    hold(g, 20.0)
    assert g.probe.shift[0] == pytest.approx((0.7 + 2.0) * math.sqrt(believed_variance(g, 0)))
    g = grasp(std=0.05)
    hold(g, 5.0)
    assert g.probe.shift[0] == 0.0


def test_a_finger_in_the_air_is_not_probed() -> None:
    g = grasp()
    watch_load(g, 0, DT, 2.0, 0.01, touching=True)
    g.probe.shift[0] = 0.3
    watch_load(g, 0, DT, math.nan, 0.01, touching=False)
    assert g.probe.shift[0] == 0.0


@pytest.mark.parametrize(
    ("given", "teaches"),
    [
        ({"relative": 0.099}, True),
        ({"relative": 0.101}, False),
        ({"quiet": 0.049}, False),
        ({"quiet": 0.051}, True),
        ({"speed": 0.99e-4}, False),
        ({"speed": 1.01e-4}, True),
        ({"held": 0.4 / 0.81}, True),
        ({"held": 0.4 / 0.79}, False),
        ({"slips": [1.0]}, False),
        ({"slips": [0.49, 0.49]}, False),
        ({"slips": [0.5, 0.5]}, True),
        ({"slips": [1.0], "other": 0.097}, True),
        ({"slips": [1.0], "other": 0.101}, False),
        ({"slips": [1.0], "probed": 0.051, "u": 0.45}, True),
        ({"slips": [1.0], "probed": 0.049, "u": 0.45}, False),
    ],
)
def test_each_rule_of_an_onset_has_its_place(given: dict, teaches: bool) -> None:
    """At 0.4, and 0.45 is not below what is expected by one and a half deviations."""
    rules = {"relative": 0.02, "quiet": 1.0, "speed": math.nan, "held": 0.0, "slips": [1.0, 1.0], "u": 0.4,
             "other": 1.0, "probed": 0.0} | given  # fmt: skip
    g = grasp()
    g.onset.quiet[0], g.onset.quiet[1] = rules["quiet"], rules["other"]
    g.onset.held[0] = rules["held"] * math.exp(len(rules["slips"]) * DT / 0.3)  # forgotten in 0.3 s
    g.probe.shift[0] = rules["probed"]
    mean = feel(g, rules["u"], rules["slips"], rules["relative"], speed=rules["speed"])
    assert (mean < LN_MU) == teaches
    assert has_taught(g, 0) == (teaches or "held" in given)  # nothing else learns of a slide that is over


@pytest.mark.parametrize(("stds", "expected"), [(1.49, True), (1.51, False)])
def test_slip_is_expected_in_a_probe_down_to_one_and_a_half_deviations(stds: float, expected: bool) -> None:
    g = grasp()
    g.probe.shift[0] = 0.3
    u = math.exp(LN_MU - stds * math.hypot(0.3, 0.05))
    assert (feel(g, u, [0.0] * 50 + [1.0]) < LN_MU) == expected


@pytest.mark.parametrize(
    ("probed", "other", "std"), [(0.051, 1.0, 0.05), (0.0, 0.09, 0.05), (0.049, 1.0, 0.15)]
)
def test_an_onset_is_a_measurement_with_its_noise_and_that_of_the_load(probed, other, std) -> None:
    """Three times the noise where no finger was let go of, and no other has just slipped."""
    g = grasp()
    feel(g, 0.6, [0.0] * 50, 0.08)
    g.probe.shift[0], g.onset.quiet[1] = probed, other
    feel(g, 0.6, [1.0, 1.0], 0.08)
    noise, prior = std**2 + 0.08**2, 0.3**2
    assert believed_variance(g, 0) == pytest.approx(prior * noise / (prior + noise))
    assert g.belief.mean[0] == pytest.approx(LN_MU + prior / (prior + noise) * (math.log(0.6) - LN_MU))


def test_an_onset_counts_the_mean_of_its_samples() -> None:
    g = grasp()
    feel(g, 0.6, [0.0] * 50 + [1.0])
    feel(g, 0.5, [1.0])
    h = grasp()
    assert g.belief.mean[0] == pytest.approx(feel(h, math.sqrt(0.3), [0.0] * 50 + [1.0, 1.0]))


def test_what_is_far_below_is_a_shock_to_all_faces() -> None:
    """From two and a half deviations on, and counted as two and a half."""
    for stds, shock in ((2.4, 0.0), (2.6, 0.08)):
        g = grasp()
        g.probe.shift[0] = 0.3
        absorb_factor(g, 0, 90.0, 90.0 * LN_MU)
        noise, known = 0.05**2 + 0.02**2, believed_variance(g, 0)
        spread, prior = math.sqrt(known + noise), known + shock**2
        feel(g, math.exp(LN_MU - stds * spread), [0.0] * 50 + [1.0, 1.0])
        off = min(stds * spread, 2.5 * math.sqrt(prior + noise))
        assert g.belief.mean[0] == pytest.approx(LN_MU - prior / (prior + noise) * off)
        assert believed_variance(g, 0) == pytest.approx(prior * noise / (prior + noise))
