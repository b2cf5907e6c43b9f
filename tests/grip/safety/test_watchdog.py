"""The watchdog: each fault gets its name, at once, and is left only after good states in a row."""

import dataclasses
import math
from collections.abc import Callable, Iterator

import pytest

from tests.grip.stages import Watchdog
from vegrip.clock import NS
from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.grip.safety import Ranges, WatchdogSettings
from vegrip.messages import Condition, FingertipState

PERIOD = 2_000_000  # [ns] 500 Hz
Change = Callable[[FingertipState], FingertipState]


def healthy(start: int = 0) -> Iterator[FingertipState]:
    """States of a finger that lives: nothing repeats."""
    count = start
    while True:
        count += 1
        wobble = 1e-3 * math.sin(count)
        yield FingertipState(
            stamp=count * PERIOD,
            finger="index",
            seq=count,
            normal_force=3.0 + wobble,
            tangential_force_x=0.5 - wobble,
            tangential_force_y=0.2 + wobble,
            torque_z=0.001 * wobble,
            displacement=1e-3 + 1e-6 * wobble,
            temperature=25.0,
            slip=0.0,
        )


@pytest.fixture
def states() -> Iterator[FingertipState]:
    return healthy()


@pytest.fixture
def watchdog(states: Iterator[FingertipState]) -> Watchdog:
    """A watchdog that has seen 50 good states."""
    dog = Watchdog(WatchdogSettings())
    for _ in range(50):
        state = next(states)
        assert dog.accept(state, state.stamp)
    assert dog.condition == Condition.OK
    return dog


def edit(**values: float) -> Change:
    return lambda state: dataclasses.replace(state, **values)


@pytest.mark.parametrize(
    ("change", "condition", "usable"),
    [
        (edit(seq=50), Condition.REPLAYED, False),
        (edit(seq=3), Condition.REPLAYED, False),
        (edit(stamp=50 * PERIOD), Condition.REPLAYED, False),
        (edit(stamp=-7), Condition.REPLAYED, False),
        (edit(normal_force=math.inf), Condition.OUT_OF_RANGE, False),
        (edit(normal_force=-9.0), Condition.OUT_OF_RANGE, False),
        (edit(tangential_force_y=1e3), Condition.OUT_OF_RANGE, False),
        (edit(torque_z=-math.inf), Condition.OUT_OF_RANGE, False),
        (edit(displacement=1.0), Condition.OUT_OF_RANGE, False),
        (edit(temperature=900.0), Condition.OUT_OF_RANGE, False),
        (edit(slip=2.0), Condition.OUT_OF_RANGE, False),
        (edit(normal_force=math.nan, displacement=math.nan), Condition.MISSING, False),
        (edit(normal_force=math.nan), Condition.DEGRADED, True),
        (edit(torque_z=math.nan), Condition.DEGRADED, True),
    ],
)
def test_each_fault_is_named_at_once(
    watchdog: Watchdog,
    states: Iterator[FingertipState],
    change: Change,
    condition: Condition,
    usable: bool,
) -> None:
    state = next(states)
    assert watchdog.accept(change(state), state.stamp) is usable
    assert watchdog.condition == condition


RANGES = {
    "normal_force": (-5.0, 60.0),
    "tangential_force_x": (-60.0, 60.0),
    "tangential_force_y": (-60.0, 60.0),
    "torque_z": (-2.0, 2.0),
    "displacement": (-0.05, 0.02),
    "temperature": (-40.0, 150.0),
    "slip": (0.0, 1.0),
    "slip_speed": (-10.0, 10.0),
    "contact_radius": (0.0, 0.05),
}


@pytest.mark.parametrize("name", RANGES)
def test_both_ends_of_a_range_are_believed_and_nothing_beyond(name: str) -> None:
    for end, beyond in zip(RANGES[name], (-math.inf, math.inf), strict=True):
        for value, told in ((end, Condition.OK), (math.nextafter(end, beyond), Condition.OUT_OF_RANGE)):
            dog, state = Watchdog(WatchdogSettings(recover_after=1)), edit(**{name: value})(next(healthy()))
            assert dog.accept(state, state.stamp) == (told is Condition.OK)
            assert dog.condition == told


def test_silence_and_broken_frames_are_told_apart_to_the_nanosecond() -> None:
    """Of 50 ms, with a broken frame 10 ms after the last good one."""
    for broken, ms, late, told in [
        (False, 50, 0, Condition.OK),
        (False, 50, 1, Condition.STALE),
        (True, 50, 0, Condition.OK),
        (True, 50, 1, Condition.CORRUPT),
        (True, 60, 0, Condition.CORRUPT),
        (True, 60, 1, Condition.STALE),
    ]:
        dog, state = Watchdog(WatchdogSettings(time_out=0.05, recover_after=1)), next(healthy())
        assert dog.accept(state, state.stamp)
        if broken:
            dog.corrupt(state.stamp + 10_000_000)
        assert dog.tick(state.stamp + ms * 1_000_000 + late) == told
        assert dog.faults == ({} if told is Condition.OK else {told: 1})


@pytest.mark.parametrize(("late", "used"), [(0, True), (1, False)])
def test_a_state_may_be_late_by_the_time_out_and_what_two_clocks_part_meanwhile(
    watchdog: Watchdog, states: Iterator[FingertipState], late: int, used: bool
) -> None:
    """They part by a 5000th of 52.010402 ms, which are 10 402 ns."""
    state = next(states)
    assert watchdog.accept(state, state.stamp + 50_010_402 + late) == used
    assert (watchdog.condition == Condition.STALE) != used


@pytest.mark.parametrize(("beyond", "used"), [(0, True), (1, False)])
def test_a_stamp_may_be_a_day_ahead_of_the_clock_as_it_was(watchdog, states, beyond: int, used: bool) -> None:
    state = next(states)
    ahead = dataclasses.replace(state, stamp=state.stamp + 86_400 * NS + beyond)
    assert watchdog.accept(ahead, state.stamp) == used
    assert (watchdog.condition == Condition.REPLAYED) != used


@pytest.mark.parametrize(
    ("still", "ns", "frozen", "doubtful"),
    [
        (True, 250_000_000, False, True),
        (True, 250_000_001, True, True),
        (False, 2_000_000_000, False, True),
        (False, 2_000_000_001, True, True),
        (False, 50_000_000, False, False),
        (False, 50_000_001, False, True),
    ],
)
def test_what_stands_still_is_frozen_or_doubted_to_the_nanosecond(
    still: bool, ns: int, frozen: bool, doubtful: bool
) -> None:
    """All values for 0.25 s, the normal force alone for 2 s; doubted from 50 ms on."""
    dog, first = Watchdog(WatchdogSettings(time_out=10.0, recover_after=1)), next(healthy())
    dog.accept(first, first.stamp)
    moved = {} if still else {"tangential_force_x": 0.7}
    again = dataclasses.replace(first, seq=2, stamp=first.stamp + ns, **moved)
    assert dog.accept(again, again.stamp) != frozen
    assert dog.condition == (Condition.FROZEN if frozen else Condition.OK)
    assert dog.doubtful == doubtful


def test_a_channel_that_never_was_there_is_not_missed(watchdog: Watchdog) -> None:
    """The contact radius is not measured by this finger; the watchdog of the fixture says OK."""
    assert watchdog.condition == Condition.OK


def test_silence_is_stale(watchdog: Watchdog) -> None:
    last = 50 * PERIOD
    assert watchdog.tick(last + 49_000_000) == Condition.OK
    assert watchdog.tick(last + 51_000_000) == Condition.STALE


def test_silence_from_the_start_is_missing() -> None:
    dog = Watchdog(WatchdogSettings())
    assert dog.tick(NS) == Condition.MISSING
    assert dog.faults == {}
    assert dog.tick(2 * NS) == Condition.MISSING


def test_a_finger_that_measures_nothing_is_missing_and_not_frozen() -> None:
    dog = Watchdog(WatchdogSettings())
    for state in (next(states) for states in [healthy()] for _ in range(300)):
        dog.accept(dataclasses.replace(state, **dict.fromkeys(MECHANICAL, math.nan)), state.stamp)
    assert dog.condition == Condition.MISSING
    assert dog.faults == {}


def test_silence_filled_with_broken_frames_is_corrupt(watchdog: Watchdog) -> None:
    watchdog.corrupt(50 * PERIOD + 30_000_000)
    assert watchdog.tick(50 * PERIOD + 51_000_000) == Condition.CORRUPT


def test_a_queue_that_delays_is_stale_though_frames_keep_coming(
    watchdog: Watchdog, states: Iterator[FingertipState]
) -> None:
    state = next(states)
    assert not watchdog.accept(state, state.stamp + 60_000_000)
    assert watchdog.condition == Condition.STALE


def test_clocks_of_two_machines_need_not_agree(states: Iterator[FingertipState]) -> None:
    dog = Watchdog(WatchdogSettings())
    offset = 7_000 * NS
    for _ in range(5000):
        state = next(states)
        assert dog.accept(state, round(state.stamp * (1 + 1e-4)) + offset)
    assert dog.condition == Condition.OK


def freeze(dog: Watchdog, states: Iterator[FingertipState], names: tuple[str, ...], seconds: float) -> None:
    stuck = next(states)
    values = {name: getattr(stuck, name) for name in names}
    for _ in range(round(seconds * NS / PERIOD)):
        state = dataclasses.replace(next(states), **values)
        dog.accept(state, state.stamp)


MECHANICAL = ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement")


def test_values_that_repeat_to_the_last_bit_are_frozen(
    watchdog: Watchdog, states: Iterator[FingertipState]
) -> None:
    freeze(watchdog, states, MECHANICAL, 0.24)
    assert watchdog.condition == Condition.OK
    freeze(watchdog, states, MECHANICAL, 0.27)
    assert watchdog.condition == Condition.FROZEN


def test_a_force_sensor_that_hangs_alone_is_frozen(
    watchdog: Watchdog, states: Iterator[FingertipState]
) -> None:
    freeze(watchdog, states, ("normal_force",), 1.9)
    assert watchdog.condition == Condition.OK
    freeze(watchdog, states, ("normal_force",), 2.1)
    assert watchdog.condition == Condition.FROZEN


def test_an_encoder_at_rest_may_repeat_itself(watchdog: Watchdog, states: Iterator[FingertipState]) -> None:
    freeze(watchdog, states, ("displacement", "temperature", "slip"), 5.0)
    assert watchdog.condition == Condition.OK


@pytest.mark.parametrize(("torque", "after"), [(1e-4, Condition.OK), (math.nan, Condition.DEGRADED)])
def test_recovery_takes_good_states_in_a_row(watchdog: Watchdog, states, torque, after) -> None:
    bad = dataclasses.replace(next(states), normal_force=math.inf)
    watchdog.accept(bad, bad.stamp)
    for _ in range(4):
        state = dataclasses.replace(next(states), torque_z=torque)
        assert watchdog.accept(state, state.stamp)  # good for the estimator, not yet for control
        assert watchdog.condition == Condition.OUT_OF_RANGE
    state = dataclasses.replace(next(states), torque_z=torque)
    watchdog.accept(state, state.stamp)
    assert watchdog.condition == after
    assert watchdog.faults == {Condition.OUT_OF_RANGE: 1}


@pytest.mark.parametrize(("torque", "after"), [(1e-4, Condition.OK), (math.nan, Condition.DEGRADED)])
def test_a_sender_that_started_anew_is_accepted_after_a_while(watchdog: Watchdog, torque, after) -> None:
    fresh = healthy()
    used = []
    for _ in range(8):
        state = dataclasses.replace(next(fresh), torque_z=torque)
        used.append(watchdog.accept(state, 50 * PERIOD + state.stamp))
    assert used == [False] * 5 + [True] * 3
    assert watchdog.condition == after


def test_a_replayed_burst_is_not_used(watchdog: Watchdog, states: Iterator[FingertipState]) -> None:
    old = healthy(start=20)
    for _ in range(4):
        assert not watchdog.accept(next(old), 50 * PERIOD)
    state = next(states)
    assert not watchdog.accept(state, state.stamp)
    assert watchdog.condition == Condition.REPLAYED


def test_faults_are_counted_by_name(watchdog: Watchdog, states: Iterator[FingertipState]) -> None:
    for _ in range(3):
        state = dataclasses.replace(next(states), torque_z=math.inf)
        watchdog.accept(state, state.stamp)
    watchdog.tick(10 * NS)
    assert watchdog.faults == {Condition.OUT_OF_RANGE: 1, Condition.STALE: 1}


def test_a_range_is_checked_where_it_is_built() -> None:
    with pytest.raises(ConfigError, match="torque_z"):
        build(Ranges, {"torque_z": [1.0, -1.0]}, "hand.toml [ranges]")


def test_one_stamp_far_ahead_is_refused_and_a_clock_that_stays_there_is_followed(
    watchdog: Watchdog, states: Iterator[FingertipState]
) -> None:
    for _ in range(50):
        state = next(states)
        assert watchdog.accept(state, state.stamp)
    state = next(states)
    assert not watchdog.accept(dataclasses.replace(state, stamp=2**63 - 1), state.stamp)
    used = []
    for _ in range(20):
        state = next(states)
        used.append(watchdog.accept(state, state.stamp))
    assert used[-1]
    assert sum(used) >= 20 - 2 * watchdog.settings.recover_after
    used = []
    for _ in range(30):
        state = next(states)
        ahead = dataclasses.replace(state, stamp=state.stamp + 10**18)
        used.append(watchdog.accept(ahead, state.stamp))
    assert used == [False] * (5 + 4) + [True] * 21  # the sixth is followed, and begins the good ones


def test_a_force_that_stands_still_is_doubted_after_a_while_and_no_sooner(states) -> None:
    settings = WatchdogSettings(frozen_chance=0.0)
    dog, told = Watchdog(settings), {}
    for state in (next(states) for _ in range(110 + round(2.0 * settings.doubt_after * NS / PERIOD))):
        still = state.seq > 100
        dog.accept(dataclasses.replace(state, normal_force=3.0) if still else state, state.stamp)
        told[(state.stamp - 101 * PERIOD) / NS] = dog.doubtful
    assert {doubted for since, doubted in told.items() if since <= settings.doubt_after} == {False}
    assert {doubted for since, doubted in told.items() if since > settings.doubt_after} == {True}


@pytest.mark.parametrize(("force_frozen_after", "is_believed"), [(3600.0, True), (3599.0, False)])
def test_a_force_that_is_not_measured_may_stand_still(states, force_frozen_after, is_believed) -> None:
    dog = Watchdog(WatchdogSettings(force_frozen_after=force_frozen_after))
    for state in (next(states) for _ in range(600)):
        still = state.seq > 400
        dog.accept(dataclasses.replace(state, normal_force=3.0) if still else state, state.stamp)
    assert (dog.condition == Condition.OK, not dog.doubtful) == (is_believed, is_believed)


COARSE = WatchdogSettings(force_frozen_after=1800.0, frozen_after=1800.0)
"""Of a sensor whose steps hide its noise: standing still by itself proves nothing."""


def presses(seconds: float, force: Callable[[float], float], travel: Callable[[float], float]) -> Watchdog:
    """Return a watchdog after a finger whose force and indentation follow time [s] at 500 Hz."""
    dog = Watchdog(COARSE)
    for n, state in zip(range(round(500 * seconds)), healthy(), strict=False):
        t = n / 500.0
        dog.accept(dataclasses.replace(state, normal_force=force(t), displacement=travel(t)), state.stamp)
    return dog


def rises(by: float) -> Callable[[float], float]:
    """Return an indentation of 1 mm that grows by ``by`` [m] from 1 s on, at 5 mm/s."""
    return lambda t: 1e-3 + math.copysign(min(max(t - 1.0, 0.0) * 5e-3, abs(by)), by)


@pytest.mark.parametrize("by", [5e-4, -5e-4])
@pytest.mark.parametrize("force", [math.nextafter(0.3, 1.0), 2.0])
def test_a_coarse_force_that_stands_while_the_tip_is_pressed_in_or_let_go_is_frozen(
    by: float, force: float
) -> None:
    assert presses(1.5, lambda _: force, rises(by)).condition == Condition.FROZEN


def test_it_stays_frozen_until_the_force_moves() -> None:
    assert presses(30.0, lambda _: 2.0, rises(5e-4)).condition == Condition.FROZEN
    assert presses(30.0, lambda t: 2.0 + (t > 29.0) * (t % 0.1), rises(5e-4)).condition == Condition.OK


@pytest.mark.parametrize(("states", "frozen"), [(100, 1), (600, 0)])
def test_a_silence_in_which_the_tip_moved_proves_nothing(states: int, frozen: int) -> None:
    """After 0.2 s its average is still another, which proves it 50 ms later; after 1.2 s it is forgotten."""
    dog = Watchdog(COARSE)
    for n, state in zip(range(1500), healthy(), strict=False):
        if not 500 < n <= 500 + states:
            travel = 1e-3 if n <= 500 else 2e-3
            dog.accept(dataclasses.replace(state, normal_force=2.0, displacement=travel), state.stamp)
            assert dog.faults.get(Condition.FROZEN, 0) == 0 or n > 601 + 25
    assert dog.faults.get(Condition.FROZEN, 0) == frozen


@pytest.mark.parametrize(
    ("force", "travel"),
    [
        (lambda _: 2.0, lambda _: 1e-3),  # at rest
        (lambda _: 2.0, lambda t: 1e-3 * (1.4 - 0.4 * math.exp(-t))),  # creep under a held force
        (lambda _: 2.0, lambda t: 1e-3 + 2e-3 * (abs(t - 2.0) < 0.025)),  # wrong values for 50 ms
        (lambda _: 2.0, lambda t: 1e-4 * math.sin(9.0 * t)),  # an indentation that begins
        (lambda _: 0.3, rises(5e-4)),  # in the air, with a sensor that is a step off
        (lambda _: 2.0, lambda t: math.nan if t > 1.0 else 1e-3),
        (lambda t: round(2e3 * rises(5e-4)(t), 1), rises(5e-4)),  # a live one, 0.1 N at 2 N/mm
    ],
)
def test_what_a_live_coarse_sensor_shows_is_not_frozen(force, travel) -> None:
    assert presses(6.0, force, travel).condition <= Condition.DEGRADED


@pytest.mark.parametrize(("part", "condition"), [(0.95, Condition.OK), (1.05, Condition.FROZEN)])
def test_a_tip_in_steady_motion_is_as_far_from_its_average_as_it_goes_in_half_a_second(
    part: float, condition: Condition
) -> None:
    speed = part * COARSE.stuck_travel / 0.5  # [m/s]
    assert presses(4.0, lambda _: 2.0, lambda t: 1e-3 + speed * t).condition == condition


@pytest.mark.parametrize(
    ("times", "condition"), [(1, Condition.OK), (4, Condition.OK), (5, Condition.DEGRADED)]
)
def test_a_channel_is_missed_once_it_came_in_five_states_in_a_row(times: int, condition: Condition) -> None:
    """A driver that fills in a torque once at the start measures none."""
    dog = Watchdog(WatchdogSettings())
    for count, state in zip(range(40), healthy(), strict=False):
        kept = state if 10 <= count < 10 + times else dataclasses.replace(state, torque_z=math.nan)
        assert dog.accept(kept, kept.stamp)
    assert dog.condition == condition


def test_a_channel_of_refused_states_alone_is_not_missed() -> None:
    dog, states = Watchdog(WatchdogSettings()), healthy()
    for count in range(40):
        state = dataclasses.replace(next(states), torque_z=math.inf if 10 <= count < 13 else math.nan)
        dog.accept(state, state.stamp)
    assert dog.condition == Condition.OK
