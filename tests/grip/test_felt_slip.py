"""What a finger feels of slip is held against its load and against its slip speed."""

import math

import pytest

from vegrip.grip.felt_slip import (
    FELT_BY_LOAD,
    FELT_BY_OTHER,
    FELT_SILENT,
    begin_felt_slip,
    believed_flag,
    believed_speed,
    judge_felt_slip,
    may_teach,
    shows_sliding,
    twist_share,
)
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory

DT = 0.002


def felt(delay: float = 0.0) -> GraspMemory:
    q = GraspMemory()
    begin_felt_slip(q, 1e-3, delay)
    return q


def feel(
    q: GraspMemory, seconds: float, slip: float, speed: float, u: float, to: float = 0.0, twist: float = 0.0
) -> None:
    """Feel the same for a while; ``u`` goes to ``to`` on the way, if that is given."""
    samples = round(seconds / DT)
    for k in range(samples):
        now = u + (to - u) * k / samples if to else u
        judge_felt_slip(q, 1, DT, slip, speed, now, twist)


def is_believed(q: GraspMemory) -> tuple[bool, bool]:
    return not math.isnan(believed_flag(q, 1, 1.0)), not math.isnan(believed_speed(q, 1, 1.0))


def test_a_finger_slides_from_the_slip_speed_on_that_was_set_and_never_where_none_was() -> None:
    q = felt()
    assert shows_sliding(q, 1e-3)
    assert not shows_sliding(q, 9e-4)
    assert not shows_sliding(q, math.nan)
    begin_felt_slip(q, 0.0, 0.0)
    assert not shows_sliding(q, 1.0)


@pytest.mark.parametrize("seconds", [0.01, 0.1, 0.5])
def test_a_slide_at_its_limit_is_believed_however_long_it_lasts(seconds: float) -> None:
    """A contact that slides has u = mu, whatever the grip does."""
    q = felt()
    feel(q, 1.0, 0.0, 0.0, 0.5)
    feel(q, seconds, 1.0, 5e-3, 0.7, 0.6)
    feel(q, 1.0, 0.0, 0.0, 0.3)
    assert is_believed(q) == (True, True)


def test_a_flag_that_stays_while_the_grip_grows_is_found_out_by_the_load_alone() -> None:
    q = felt()
    feel(q, 1.0, 0.0, math.nan, 0.5)
    feel(q, 0.2, 1.0, math.nan, 0.5, 0.2)
    assert is_believed(q) == (False, True)
    assert q.felt.why[1] == FELT_BY_LOAD


def test_a_slip_speed_that_stays_while_the_grip_grows_is_found_out_by_the_load() -> None:
    q = felt()
    feel(q, 0.2, math.nan, 0.5, 0.5, 0.2)
    assert is_believed(q) == (True, False)
    assert q.felt.why[BELIEF_MOST + 1] == FELT_BY_LOAD


def test_a_flag_without_slip_speed_is_found_out_before_the_grip_has_grown_much() -> None:
    q = felt()
    feel(q, 0.04, 1.0, 2e-5, 0.5)
    assert is_believed(q) == (True, True)
    feel(q, 0.02, 1.0, 2e-5, 0.5)
    assert is_believed(q) == (False, True)
    assert q.felt.why[1] == FELT_BY_OTHER


def test_a_flag_that_is_silent_or_late_in_a_slide_is_found_out_by_the_slip_speed() -> None:
    q = felt()
    feel(q, 0.2, 0.0, 5e-3, 0.7)
    assert is_believed(q) == (False, True)
    assert q.felt.why[1] == FELT_SILENT


def test_a_patch_that_is_twisted_slides_in_part_without_a_flag() -> None:
    q = felt()
    feel(q, 0.2, 0.0, 5e-3, 0.7, twist=0.8)
    assert is_believed(q) == (True, True)
    assert twist_share(0.3, 0.5) == pytest.approx(0.4)


def test_what_is_felt_late_is_given_so_much_longer() -> None:
    q = felt(delay=0.1)
    feel(q, 0.2, 0.0, 5e-3, 0.7)
    feel(q, 0.1, 1.0, 2e-5, 0.5, 0.2)
    assert is_believed(q) == (True, True)


def test_a_channel_is_believed_again_when_it_has_been_quiet_for_long_enough() -> None:
    q = felt()
    feel(q, 1.0, 1.0, 2e-5, 0.5)
    feel(q, 29.0, 0.0, 0.0, 0.5)
    assert is_believed(q) == (False, True)
    feel(q, 1.1, 0.0, 0.0, 0.5)
    assert is_believed(q) == (True, True)


def test_single_samples_that_go_on_while_the_grip_grows_are_found_out_by_the_load() -> None:
    q = felt()
    feel(q, 1.0, 0.0, math.nan, 0.5)
    for k in range(10):
        feel(q, DT, 1.0, math.nan, 0.5 if k < 3 else 0.2)
        feel(q, 0.1, 0.0, math.nan, 0.5 if k < 3 else 0.2)
    assert is_believed(q) == (False, True)
    assert q.felt.why[1] == FELT_BY_LOAD


def test_a_slide_is_over_where_the_load_has_fallen_far_below_what_it_was() -> None:
    q = felt()
    feel(q, 0.01, 1.0, math.nan, 0.5)
    assert believed_flag(q, 1, 1.0) == 1.0
    feel(q, 2 * DT, 1.0, math.nan, 0.2)
    assert believed_flag(q, 1, 1.0) == 0.0


@pytest.mark.parametrize("slip", [0.5, 0.999, 1e-9, math.nan])
def test_what_lies_between_0_and_1_is_no_flag(slip: float) -> None:
    assert math.isnan(believed_flag(felt(), 1, slip))


def test_only_a_flag_that_was_silent_before_teaches() -> None:
    q = felt()
    assert not may_teach(q, 1)
    feel(q, 0.6, 0.0, math.nan, 0.5)
    assert may_teach(q, 1)
    feel(q, 0.1, 1.0, math.nan, 0.5)
    assert may_teach(q, 1)  # it had been
    feel(q, DT, math.nan, math.nan, 0.5)
    assert not may_teach(q, 1)


def test_a_load_that_is_not_known_contradicts_nothing() -> None:
    q = felt()
    feel(q, 1.0, 1.0, math.nan, math.nan)
    assert is_believed(q) == (True, True)


def lasts(q: GraspMemory, *felt: float, channel: int = 0) -> float:
    """Return for how long [s] the same (slip, speed, u, twist) is felt until the channel is not believed."""
    for k in range(1, 2000):
        judge_felt_slip(q, 1, 0.001, *felt)
        if q.felt.off[channel + 1] > 0.0:
            return 0.001 * k
    return math.inf


@pytest.mark.parametrize("delay", [0.0, 0.1])
@pytest.mark.parametrize(
    ("felt", "seconds"),
    [
        ((0.0, 5e-3, 0.7, 0.0), 0.15),
        ((0.0, 5e-3, 0.7, 0.49), 0.15),
        ((0.0, 5e-3, 0.7, 0.51), math.inf),
        ((0.49, 5e-3, 0.7, 0.0), 0.15),
        ((0.5, 5e-3, 0.7, 0.0), math.inf),
        ((0.0, 0.99e-3, 0.7, 0.0), math.inf),
        ((1.0, 0.99e-4, 0.7, 0.0), 0.05),
        ((1.0, 1.01e-4, 0.7, 0.0), math.inf),
        ((1.0, math.nan, 0.7, 0.0), math.inf),
        ((math.nan, 5e-3, 0.7, 0.0), math.inf),
    ],
)
def test_how_long_flag_and_slip_speed_may_contradict_each_other(delay, felt, seconds) -> None:
    """Besides the delay that they are told to have; what a bad moment adds is forgotten in two seconds."""
    q = felt_at(delay)
    told = seconds + delay
    assert lasts(q, *felt) == pytest.approx(
        -2.0 * math.log(1.0 - 0.5 * told) if seconds == 0.05 else told, abs=2e-3
    )
    if seconds == 0.15:
        q = felt_at(delay)
        for _ in range(5):  # each time anew
            feel(q, 0.1 + delay, *felt[:3], twist=felt[3])
            feel(q, 0.02, 1.0, 5e-3, 0.7)
        assert is_believed(q) == (True, True)
    if seconds == 0.05:
        q = felt_at(delay)
        feel(q, 0.03, *felt[:3])
        feel(q, 2.0, 0.0, 0.0, 0.5)
        left = 0.05 + delay - 0.03 / math.e
        assert lasts(q, *felt) == pytest.approx(left, abs=0.012)


def felt_at(delay: float) -> GraspMemory:
    q = felt(delay)
    feel(q, 0.1, 0.0, 0.0, 0.5)
    feel(q, DT, 1.0, 5e-3, 0.7)
    return q


@pytest.mark.parametrize("delay", [0.0, 0.05])
@pytest.mark.parametrize(("slip", "speed", "channel"), [(1.0, math.nan, 0), (math.nan, 2e-3, BELIEF_MOST)])
def test_how_far_and_for_how_long_the_load_may_fall_under_a_slide(delay, slip, speed, channel) -> None:
    """Below six tenths of the largest of the burst for 30 ms; a second of silence ends a burst."""
    for share, seconds in ((0.59, 0.03), (0.61, math.inf)):
        q = felt(delay)
        feel(q, 0.1, slip, speed, 0.5)
        assert lasts(q, slip, speed, share * 0.5, 0.0, channel=channel) == pytest.approx(
            delay + seconds, abs=0.0021
        )
    silent = 0.0 if slip == 1.0 else math.nan, 0.0 if slip != 1.0 else math.nan
    for pause, is_over in ((0.98, True), (1.02, False)):
        q = felt(delay)
        feel(q, 0.1, slip, speed, 0.5)
        feel(q, pause, *silent, 0.5)
        feel(q, 2 * DT, slip, speed, 0.2)
        believed = believed_flag(q, 1, slip) if slip == 1.0 else believed_speed(q, 1, speed)
        assert (believed == 0.0) == is_over


def test_a_flag_teaches_after_half_a_second_of_silence() -> None:
    for seconds, teaches in ((0.49, False), (0.51, True)):
        q = felt()
        feel(q, seconds, 0.0, math.nan, 0.5)
        assert may_teach(q, 1) == teaches
