"""The node: what it answers, when it is silent, and how the fingers share the grasp."""

import dataclasses
import math
from collections.abc import Callable
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.config import build
from vegrip.errors import ConfigError, UsageError
from vegrip.grip.learned_store import InMemory
from vegrip.grip.node import GraspForce
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.grip.wires import LEFT_ALONE
from vegrip.messages import (
    Condition,
    ContactEstimate,
    FingertipState,
    ForceCommand,
    GraspPhase,
    ModelHealth,
    Reason,
    SlipMargin,
)

MakeNode = Callable[..., GraspForce]
MakeState = Callable[..., FingertipState]
PERIOD = 2_000_000  # [ns]
MU = 0.8  # of the estimator of these tests


def commands(answers: object) -> list[ForceCommand]:
    return [message for message in answers if isinstance(message, ForceCommand)]  # type: ignore[attr-defined]


def feed(node: GraspForce, state: FingertipState, now: int | None = None) -> ForceCommand:
    (command,) = commands(node.on_message(state, state.stamp if now is None else now))
    return command


def test_a_state_is_answered_with_command_first_then_contact_margin_and_health(
    make_node: MakeNode, state: MakeState
) -> None:
    answers = list(make_node().on_message(state(1), PERIOD))
    assert [type(message) for message in answers] == [ForceCommand, ContactEstimate, SlipMargin, ModelHealth]


def test_estimates_are_told_less_often_than_commands(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    answers = [m for i in range(1, 501) for m in node.on_message(state(i), i * PERIOD)]
    kinds = [type(message) for message in answers]
    assert kinds.count(ForceCommand) == 500
    assert kinds.count(SlipMargin) == 50  # one second, every 20 ms
    assert kinds.count(ModelHealth) == 6  # every 0.2 s, and when the finger is first believed


def test_reports_of_a_kind_count_up_one_by_one_from_0(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    answers = [m for i in range(1, 501) for m in node.on_message(state(i), i * PERIOD)]
    for kind, count in ((ContactEstimate, 50), (SlipMargin, 50), (ModelHealth, 6)):
        assert [m.seq for m in answers if isinstance(m, kind)] == list(range(count))


def test_reports_of_up_to_five_groups_of_fingers_come_at_different_times_of_a_period(
    make_node: MakeNode, state: MakeState
) -> None:
    """Each begins with the first state of its finger; the second is early by its share of a period."""
    fingers, shares = tuple("abcdefg"), (0.0, 0.0, 0.2, 0.4, 0.4, 0.6, 0.8)
    node, told = make_node(fingers), {}
    for i in range(1, 150):
        for name in fingers:
            for message in node.on_message(state(i, name), i * PERIOD):
                told.setdefault((type(message), name), []).append(i * PERIOD / 1e9)
    for kind, period in ((SlipMargin, 0.02), (ContactEstimate, 0.02), (ModelHealth, 0.2)):
        for name, share in zip(fingers, shares, strict=True):
            first, *later = told[kind, name]
            second = next(time for time in later if time > first + 0.01 or kind is not ModelHealth)
            assert 0.0 <= second - first - period * (1.0 - share) + 1e-9 <= PERIOD / 1e9 + 2e-9


def test_a_change_of_the_condition_is_told_with_the_state_or_tick_that_shows_it(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()
    told = []
    for i in range(1, 401):
        answers = []
        if not 200 < i <= 250:  # silence of 100 ms
            force = 1000.0 if 100 < i <= 103 else 1.0
            answers += node.on_message(state(i, normal_force=force), i * PERIOD)
        answers += node.on_tick(i * PERIOD)
        told += [(i, m.condition) for m in answers if isinstance(m, ModelHealth)]
    changes = [one for before, one in pairwise(told) if one[1] is not before[1]]
    assert changes == [
        (5, Condition.OK),
        (101, Condition.OUT_OF_RANGE),
        (108, Condition.OK),
        (226, Condition.STALE),
        (255, Condition.OK),
    ]


def test_the_first_command_is_the_force_that_is_there(make_node: MakeNode, state: MakeState) -> None:
    command = feed(make_node(), state(1, normal_force=3.7, tangential_force_x=0.1))
    assert command.normal_force == 3.7
    assert command.adjustment == 0.0


def test_the_grip_rises_to_the_least_force_for_the_wanted_margin(
    make_node: MakeNode, state: MakeState
) -> None:
    settings = ControlSettings(thumb="", grip=GripSettings(wanted_margin=0.2))
    node = make_node(settings=settings)
    for i in range(1, 200):
        command = feed(node, state(i, tangential_force_x=4.0))
    assert command.normal_force == pytest.approx(4.0 / (MU * 0.8))
    assert command.reason == Reason.HOLD


def test_the_thumb_carries_what_the_fingers_press(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(("thumb", "index", "middle"))
    last = {}
    for i in range(1, 400):
        for finger, load in (("thumb", 0.5), ("index", 2.0), ("middle", 1.5)):
            last[finger] = feed(node, state(i, finger, tangential_force_x=load))
    assert last["thumb"].normal_force == pytest.approx(
        last["index"].normal_force + last["middle"].normal_force, rel=1e-3
    )


def test_a_load_that_no_force_carries_gets_the_largest(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(settings=ControlSettings(thumb=""))
    for i in range(1, 400):
        command = feed(node, state(i, tangential_force_x=50.0))
    node.fingers["index"].estimator.least_force = lambda *_: math.inf
    for i in range(400, 800):
        command = feed(node, state(i))
    assert (command.normal_force, command.reason) == (ControlSettings().limits.max_force, Reason.MAX_LIMIT)
    del node.fingers["index"].estimator.least_force
    for i in range(800, 1800):
        command = feed(node, state(i))
    assert command.normal_force < 0.8 * ControlSettings().limits.max_force  # and it comes down again


def test_a_state_of_an_unknown_finger_is_counted_and_ignored(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    assert list(node.on_message(state(1, "toe"), PERIOD)) == []
    assert node.rejected == {"unknown finger": 1}


def test_what_is_not_a_state_is_ignored(make_node: MakeNode) -> None:
    assert list(make_node().on_message(ModelHealth(stamp=1, finger="index", seq=1), 1)) == []


def test_a_node_that_is_not_active_commands_nothing(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    feed(node, state(1))
    node.deactivate()
    assert list(node.on_message(state(2), 2 * PERIOD)) == []
    assert list(node.on_tick(10**9)) == []


def test_nothing_is_commanded_to_a_finger_that_was_never_heard(make_node: MakeNode) -> None:
    node = make_node()
    answers = [m for i in range(1000) for m in node.on_tick(i * PERIOD)]
    assert commands(answers) == []
    healths = [m for m in answers if isinstance(m, ModelHealth)]
    assert healths
    assert {m.condition for m in healths} == {Condition.MISSING}


def test_activation_begins_afresh(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    feed(node, state(1, normal_force=9.0))
    node.deactivate()
    node.activate()
    assert feed(node, state(2, normal_force=3.0)).normal_force == 3.0


def test_commands_are_counted_and_expire(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(settings=ControlSettings(limits=LimitSettings(lifetime=0.04)))
    issued = [feed(node, state(i)) for i in range(1, 20)]
    assert [c.seq for c in issued] == list(range(1, 20))
    assert all(c.expires - c.stamp == 40_000_000 for c in issued)


def test_a_command_is_renewed_before_it_expires_though_states_are_slow(
    make_node: MakeNode, state: MakeState
) -> None:
    settings = build(ControlSettings, {"watchdog": {"time_out": 0.5}, "limits": {"lifetime": 0.1}}, "test")
    node = make_node(settings=settings)
    last = feed(node, state(1))
    for i in range(2, 200):
        for command in commands(node.on_tick(i * PERIOD)):
            assert command.stamp < last.expires
            last = command
        assert last.expires > i * PERIOD


def test_felt_slip_raises_the_grip(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    for i in range(1, 10):
        before = feed(node, state(i)).normal_force
    command = feed(node, state(10, slip=1.0))
    assert command.normal_force > before
    assert command.reason == Reason.SLIP


def test_a_fault_of_the_node_itself_is_ridden_out_without_its_estimators(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()
    held = feed(node, state(1)).normal_force
    del node.fingers["index"].numbers.estimator, node.fingers["index"].numbers.own
    forces = [c.normal_force for i in range(2, 600) for c in commands(node.on_fault(i * PERIOD))]
    assert forces[0] == held
    assert forces == sorted(forces)
    assert forces[-1] == ControlSettings().fail_safe.force


def test_after_a_fault_of_the_node_the_grip_is_taken_over_as_it_is(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()
    feed(node, state(1, normal_force=6.0))
    node.on_fault(100_000_000)
    node.deactivate()
    node.activate()
    assert feed(node, state(60, normal_force=0.5, tangential_force_x=0.0)).normal_force >= 6.0
    assert node.fingers["index"].estimator.resets == 1  # type: ignore[attr-defined]


def test_parameters_changed_while_running_take_effect(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    for i in range(1, 10):
        assert feed(node, state(i, normal_force=8.0)).normal_force == 8.0
    node.parameters = dataclasses.replace(node.parameters, limits=LimitSettings(max_force=5.0))
    command = feed(node, state(10, normal_force=8.0))
    assert (command.normal_force, command.reason) == (5.0, Reason.MAX_LIMIT)


def test_input_that_is_lost_is_logged_at_once_and_once_until_it_is_trusted_again(
    make_node: MakeNode, state: MakeState, caplog: pytest.LogCaptureFixture
) -> None:
    node = make_node()
    logged: dict[str, int] = {}
    silent = {*range(300, 400), *range(700, 710), *range(720, 760)}  # of the periods; 50 ms are the time-out
    with caplog.at_level("INFO"):
        for i in range(1, 1001):
            now = i * PERIOD
            list(node.on_tick(now) if i in silent else node.on_message(state(i), now))
            logged |= {text: i for text in caplog.messages if text not in logged}
    about = [text for text in caplog.messages if text.startswith("input")]
    lost = "input of index is lost: no state came within the time-out"
    back = "input of index is trusted again"
    assert about == [lost, back, lost, back]
    assert 300 + 25 <= logged[lost] <= 300 + 30
    assert 400 < logged[back] <= 400 + 110  # a report of the health later


class Store(InMemory):
    """Counts how often what is learned was to be kept."""

    def __init__(self) -> None:
        super().__init__()
        self.saved = 0

    def save(self) -> None:
        self.saved += 1


def test_before_it_is_configured_and_active_a_node_answers_nothing(
    make_node: MakeNode, state: MakeState
) -> None:
    made = make_node()
    node = GraspForce("grasp", ("index",), made._make_estimator, ControlSettings())
    frame = np.zeros(64, dtype=np.uint8)

    def silent() -> bool:
        answers = [*node.on_message(state(1), PERIOD), *node.on_tick(PERIOD), *node.on_fault(PERIOD)]
        found = (
            node.on_batch(b"", 0, 0, 0),
            node.on_packet(b"", 0, 0),
            node.on_frame("index", frame, 48, 0, 0),
        )
        return answers == [] and found == (None, None, LEFT_ALONE)

    assert node.fingers == {}
    assert node.path_taken == "no finger is configured"
    assert list(node.reports("index", 0)) == []
    assert silent()
    with pytest.raises(ConfigError, match="'contacts' has toe"):
        node.parameters = ControlSettings(contacts={"toe": {}})
    with pytest.raises(UsageError, match="is not active"):
        node.grasp({})
    node.configure()
    assert silent()
    with pytest.raises(UsageError, match="is not active"):
        node.grasp({})
    node.activate()
    assert node.on_frame("toe", frame, 48, 0, 0) == LEFT_ALONE
    assert not silent()
    node.cleanup()
    assert node.fingers == {}
    assert silent()


def test_what_is_learned_is_kept_at_each_end_of_a_use_and_an_unused_estimate_is_not_reset(
    make_node: MakeNode,
) -> None:
    store, make = Store(), make_node()._make_estimator
    node = GraspForce("grasp", ("index",), make, ControlSettings(), store)
    kept = []
    for transition in (
        *("configure", "activate", "deactivate", "activate", "cleanup"),
        "configure",
        "activate",
    ):
        getattr(node, transition)()
        kept.append(store.saved)
    assert kept == [0, 0, 0, 1, 2, 2, 2]
    assert node.fingers["index"].estimator.resets == 0  # type: ignore[attr-defined]


def test_a_tick_tells_of_a_finger_at_fault_and_of_no_other(make_node: MakeNode, state: MakeState) -> None:
    nan = math.nan
    for changes, condition in (({}, Condition.OK), ({"tangential_force_x": nan}, Condition.DEGRADED)):
        node = make_node()
        for i in range(1, 100):
            list(node.on_message(state(i, **changes if i > 50 else {}), i * PERIOD))
        assert node.fingers["index"].condition is condition
        renewed = list(node.on_tick(99 * PERIOD + 40_000_000))
        assert [type(one) for one in renewed] == [ForceCommand]
    silent = list(node.on_tick(99 * PERIOD + 60_000_000))
    assert {type(one) for one in silent} >= {ContactEstimate, SlipMargin, ModelHealth}


@pytest.mark.parametrize(
    ("carries", "end"),
    [
        ({}, ", as messages: one does not come in one CAN FD frame of our own layout, or comes in"
         " restored order (order_window) or by the hand's clock (estimate_clock)"),
        ({"thumb": True, "index": False},
         ", as messages: no frame can say that a command lives for 0.1 s (limits.lifetime)"),
        ({"thumb": True, "index": True}, ", in halves: the estimator is of another make"),
    ],
)  # fmt: skip
def test_how_states_are_answered_is_said_with_the_reason(
    make_node: MakeNode, carries: dict[str, bool], end: str
) -> None:
    node = make_node(("thumb", "index"))
    node._lines = {name: SimpleNamespace(carries=lambda _, can=can: can) for name, can in carries.items()}  # type: ignore[misc]
    assert node.path_taken.startswith("states are answered by the compiled step (")
    assert node.path_taken.endswith(f"){end}")


def test_before_the_first_state_of_a_finger_nothing_is_held_proven_or_heard(make_node: MakeNode) -> None:
    memory = make_node().fingers["index"].memory
    for name in ("HELD", "ENVELOPE"):
        assert math.isnan(memory[f"GRIP_{name}"])
    assert [memory[f"GRIP_{name}"] for name in ("ELAPSED", "PRESENT", "MEDIAN")] == [-math.inf] * 3
    assert memory["GRIP_PROVEN"] == math.inf
    assert memory["TURN_REPORTED_CONDITION"] not in [*Condition]
    assert (memory["INPUT_CONDITION"], memory["INPUT_QUICKEST"]) == (Condition.MISSING, 2**62)


def test_a_finger_that_is_restarted_knows_its_command_and_nothing_of_its_input(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()
    finger = node.fingers["index"]
    for i in range(1, 100):
        list(node.on_message(state(i, normal_force=1e3 if i == 50 else 3.0, slip=float(i == 99)), i * PERIOD))
    held, seq = finger.held, finger.memory["TURN_SEQ"]
    assert finger.faults == {Condition.OUT_OF_RANGE: 1}
    (standing,) = node.standing_commands()
    assert finger.command().adjustment != 0.0
    assert dataclasses.replace(standing, reason=finger.command().reason) == dataclasses.replace(
        finger.command(), adjustment=0.0
    )
    finger.restart()
    assert (finger.faults, finger.condition, finger.held) == ({}, Condition.MISSING, held)
    names = ("TURN_SEEN", "TURN_HAS_MARGIN", "INPUT_IS_RECEIVED", "INPUT_RECEIVED", "TURN_SEQ")
    assert [finger.memory[name] for name in names] == [0, 0, 0, 0, seq]
    finger.note_broken(7)
    assert (finger.memory["INPUT_CORRUPT"], finger.memory["INPUT_IS_CORRUPT"]) == (7, 1)


def test_all_times_of_a_finger_move_with_its_clock_and_none_beyond_64_bits(make_node: MakeNode) -> None:
    finger = make_node().fingers["index"]
    memory, since = finger.memory, finger.memory.section("REPEAT_SINCE")
    times = (
        *("INPUT_RECEIVED", "INPUT_CORRUPT", "INPUT_STILL_SINCE", "INPUT_FORCE_STILL_SINCE"),
        *("INPUT_TRAVEL_SINCE", "TURN_TRANSFER_SINCE", "TURN_COMMANDED", "TURN_ASKED", "TURN_USED"),
    )
    for i, name in enumerate(times):
        memory[name] = 1000 + i
    since[:] = 2000 + np.arange(since.size)
    memory["INPUT_QUICKEST"] = 5
    finger.move_times(-300)
    assert [memory[name] for name in times] == [700 + i for i in range(len(times))]
    assert since.tolist() == [1700 + i for i in range(since.size)]
    assert memory["INPUT_QUICKEST"] == 2**62
    finger.move_times(2**63 - 1)
    assert {memory[name] for name in times} | set(since.tolist()) == {2**63 - 1}


def test_a_goal_sets_the_limits_at_once_and_stands_through_a_fault_of_the_node_but_not_a_new_use(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()

    def kept() -> tuple[float, float, bool]:
        limits = node.controller.settings.limits
        return limits.min_force, limits.max_force, node.controller.limit_watch.is_letting_go

    assert node.limit_is_stated  # only who builds a node of a file knows that it is not
    assert kept() == (0.3, 15.0, False)
    feed(node, state(1))
    node.grasp({"force": 3.0, "max_force": 4.0})
    assert kept() == (3.0, 4.0, False)
    node.parameters = dataclasses.replace(node.parameters, limits=LimitSettings(max_force=3.5))
    assert kept() == (3.0, 3.5, False)
    node.on_fault(2 * PERIOD)
    for transition in ("deactivate", "activate"):
        getattr(node, transition)()
    assert (kept(), node.grasp_status(0).phase) == ((3.0, 3.5, False), GraspPhase.CLOSING)
    node.release({})
    assert kept() == (0.3, pytest.approx(node.fingers["index"].held), True)
    for transition in ("deactivate", "activate"):
        getattr(node, transition)()
    assert (kept(), node.grasp_status(0).phase) == ((0.3, 3.5, False), GraspPhase.NONE)


def test_a_state_without_numbers_is_answered_by_nothing(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    for i in range(1, 20):
        broken = dataclasses.replace(state(i), slip=None)  # type: ignore[arg-type]
        assert list(node.on_message(broken, i * PERIOD)) == []
    assert feed(node, state(20)).seq == 1
    assert list(node.on_message(broken, 21 * PERIOD)) == []
