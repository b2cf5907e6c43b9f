"""Every fault: the finger is marked, its command never falls, and then ramps to the fail-safe grip."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vegrip.grip.node import GraspForce
from vegrip.grip.safety import WatchdogSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Condition, FingertipState, ForceCommand, ModelHealth, Reason

MakeNode = Callable[..., GraspForce]
MakeState = Callable[..., FingertipState]
PERIOD = 2_000_000  # [ns]
FAULT_AT = 500  # [states]
SECONDS = 2.0
CHANNELS = [
    field.name for field in dataclasses.fields(FingertipState) if field.name not in ("stamp", "finger", "seq")
]


def nothing(state: FingertipState) -> FingertipState | None:
    del state
    return None


def all_nan(state: FingertipState) -> FingertipState:
    return dataclasses.replace(state, **dict.fromkeys(CHANNELS, math.nan))


def edit(**values: float) -> Callable[[FingertipState], FingertipState]:
    return lambda state: dataclasses.replace(state, **values)


def frozen(state: FingertipState) -> FingertipState:
    return dataclasses.replace(state, normal_force=3.0, torque_z=0.0)


def duplicated(state: FingertipState) -> FingertipState:
    return dataclasses.replace(state, seq=FAULT_AT - 1, stamp=(FAULT_AT - 1) * PERIOD)


FAULTS = {
    "silence": (nothing, Condition.STALE),
    "all channels NaN": (all_nan, Condition.MISSING),
    "force infinite": (edit(normal_force=math.inf), Condition.OUT_OF_RANGE),
    "force far too great": (edit(normal_force=1e6), Condition.OUT_OF_RANGE),
    "torque out of range": (edit(torque_z=-50.0), Condition.OUT_OF_RANGE),
    "values frozen": (frozen, Condition.FROZEN),
    "one state again and again": (duplicated, Condition.REPLAYED),
    "tangential force lost": (
        edit(tangential_force_x=math.nan, tangential_force_y=math.nan),
        Condition.DEGRADED,
    ),
    "torque lost": (edit(torque_z=math.nan), Condition.DEGRADED),
}


def run(node: GraspForce, states: Iterable[FingertipState | None]) -> list[ForceCommand | ModelHealth]:
    answers = []
    for i, state in enumerate(states, start=1):
        now = i * PERIOD
        if state is not None:
            answers += list(node.on_message(state, now))
        answers += list(node.on_tick(now))
    return [m for m in answers if isinstance(m, (ForceCommand, ModelHealth))]


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named_and_never_lowers_the_command(
    make_node: MakeNode, state: MakeState, name: str
) -> None:
    fault, condition = FAULTS[name]
    node = make_node(settings=ControlSettings(thumb=""))
    last = FAULT_AT + round(SECONDS / 0.002)
    states = [fault(state(i)) if i >= FAULT_AT else state(i) for i in range(1, last)]
    answers = run(node, states)
    commands = [m for m in answers if isinstance(m, ForceCommand)]
    safe = [c for c in commands if c.stamp < FAULT_AT * PERIOD][-1].normal_force
    after = [c for c in commands if c.stamp >= FAULT_AT * PERIOD]
    late = [c for c in after if c.stamp > (FAULT_AT + 300) * PERIOD]  # the fault has been seen by then

    assert node.fingers["index"].condition == condition
    assert {m.condition for m in answers if isinstance(m, ModelHealth)} >= {Condition.OK, condition}
    if name != "values frozen":  # until it is seen, a frozen sensor is a sensor
        assert min(c.normal_force for c in after) >= safe
    forces = [c.normal_force for c in late]
    assert forces == sorted(forces)
    assert forces[-1] == ControlSettings().fail_safe.force
    assert {c.reason for c in late} <= {Reason.INPUT_HOLD, Reason.UNTRUSTED, Reason.FAIL_SAFE}


@pytest.mark.parametrize("name", FAULTS)
def test_a_grip_stronger_than_the_fail_safe_is_kept(make_node: MakeNode, state: MakeState, name: str) -> None:
    fault, _ = FAULTS[name]
    node = make_node(settings=ControlSettings(thumb=""))
    heavy = {"tangential_force_x": 6.0}
    states = [state(i, **heavy) for i in range(1, FAULT_AT)]
    safe = [m for m in run(node, states) if isinstance(m, ForceCommand)][-1].normal_force
    assert safe > ControlSettings().fail_safe.force
    if name == "values frozen":
        heavy |= {"displacement": 1e-3}
    states = [fault(state(i, **heavy)) for i in range(FAULT_AT, FAULT_AT + 1000)]
    for i, broken in enumerate(states, start=FAULT_AT):
        if broken is not None:
            node.on_message(broken, i * PERIOD)
        for message in node.on_tick(i * PERIOD):
            if isinstance(message, ForceCommand):
                assert message.normal_force >= safe


def test_a_rise_under_way_is_completed_when_the_input_fails(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(settings=ControlSettings(thumb=""))
    run(node, [state(i) for i in range(1, 100)])
    node.on_message(state(100, tangential_force_x=6.0), 100 * PERIOD)
    (first, *_) = node.on_message(state(101, tangential_force_x=6.0), 101 * PERIOD)
    assert isinstance(first, ForceCommand)
    assert first.reason == Reason.RATE_LIMIT
    for i in range(102, 400):
        node.on_tick(i * PERIOD)
    assert node.fingers["index"].held == pytest.approx(6.0 / (0.8 * 0.85), rel=0.05)


def test_after_recovery_control_goes_on_without_a_step_down(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(settings=ControlSettings(thumb=""))
    states = [None if 500 <= i < 1000 else state(i) for i in range(1, 3000)]
    forces = [m.normal_force for m in run(node, states) if isinstance(m, ForceCommand)]
    falls = [before - after for before, after in itertools.pairwise(forces)]
    assert max(falls) <= ControlSettings().limits.lower_rate * 0.05  # never faster than the limit
    assert node.fingers["index"].condition == Condition.OK
    assert forces[-1] < ControlSettings().fail_safe.force  # the need is met with less again


anything = st.floats(allow_nan=True, allow_infinity=True)
hostile = st.builds(
    FingertipState,
    stamp=st.integers(-(2**63), 2**63),
    finger=st.sampled_from(["thumb", "index", "toe", ""]),
    seq=st.integers(-(2**40), 2**40),
    **dict.fromkeys(CHANNELS, anything),
)


# The fixtures only give functions, so nothing is carried from one example to the next.
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    arrivals=st.lists(st.tuples(st.integers(0, 200_000_000), st.booleans(), hostile), min_size=1, max_size=60)
)
def test_no_input_raises_or_gets_a_command_past_its_limits(
    make_node: MakeNode, state: MakeState, arrivals: list[tuple[int, bool, FingertipState]]
) -> None:
    """Hostile states, mixed with good ones, at any pace."""
    node = make_node(("thumb", "index"))
    limits = node.parameters.limits
    now, last = 0, {}
    for i, (pause, good, bad) in enumerate(arrivals, start=1):
        now += pause
        given_state = dataclasses.replace(state(i), stamp=now) if good else bad
        for message in [*node.on_message(given_state, now), *node.on_tick(now)]:
            if not isinstance(message, ForceCommand):
                continue
            assert limits.min_force <= message.normal_force <= limits.max_force
            if message.finger in last:
                before = last[message.finger]
                elapsed = (message.stamp - before.stamp) * 1e-9
                assert message.normal_force - before.normal_force <= limits.raise_rate * elapsed + 1e-9
                assert before.normal_force - message.normal_force <= limits.lower_rate * elapsed + 1e-9
                assert message.seq == before.seq + 1
            assert message.expires > now
            last[message.finger] = message


@pytest.mark.parametrize("stuck", [0.0, 2.0])
def test_a_force_that_stands_still_lowers_nothing_before_it_counts_as_frozen(
    make_node: MakeNode, state: MakeState, stuck: float
) -> None:
    """A broken wire often reads zero: the finger must not believe at once that it is in the air.

    Where the sensor's noise is too small to be missed, only the time it stands still is left to go by.
    """
    slow = WatchdogSettings(frozen_chance=0.0)
    node = make_node(settings=ControlSettings(thumb="", watchdog=slow))
    states = [
        state(i, normal_force=stuck, tangential_force_x=0.1) if i >= FAULT_AT else state(i)
        for i in range(1, FAULT_AT + 900)
    ]
    forces = [m.normal_force for m in run(node, states) if isinstance(m, ForceCommand)]
    assert node.fingers["index"].condition == Condition.OK, "not frozen yet"
    assert node.fingers["index"].memory["INPUT_DOUBTFUL"]
    doubted = forces[FAULT_AT + 30 :]
    assert min(doubted) == max(doubted)
    assert doubted[0] > 0.9 * forces[FAULT_AT - 2]
