"""The board keeps the newest, knows how old it is, notes what changes or falls silent, and does not grow."""

import json
import math
from collections.abc import Iterable

import pytest

from vegrip.clock import NS
from vegrip.messages import (
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    Lifecycle,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)
from vegrip.runtime.monitor.board import MOST_FINGERS, Board, as_json
from vegrip.runtime.monitor.rows import FRESH, Presence, Present

GRASP, HAND, RECORD = "/grasp_force", "/virtual_hand", "/record"
LOOK = 0.1  # [s]


def command(seq: int, reason: Reason) -> ForceCommand:
    return ForceCommand(seq, "index", seq, 2.0, 0.0, reason, seq + NS)


def health(condition: Condition, finger: str = "index") -> ModelHealth:
    return ModelHealth(0, finger, 0, condition)


def texts(board: Board) -> list[str]:
    return [line.text for line in board.log]


def alarms(board: Board) -> list[str]:
    return [line.text for line in board.log if "red" in line.style or "yellow" in line.style]


class Watched:
    """A board in simulated time: nodes that say what they say, looked at ten times a second."""

    def __init__(self, fingers: tuple[str, ...] = ("index",)) -> None:
        self.board = Board(0, fingers)
        self.now = 0.0  # [s]
        self.running = {GRASP: 1, HAND: 2, RECORD: 3}  # name: pid, as the registry has it
        self.says = set(self.running)
        self.killed: set[str] = set()
        self.condition = Condition.OK
        self.rejected: dict[str, int] = {}
        self.misses, self.late = 0, (GRASP,)
        self._seq = 0

    def pass_by(self, seconds: float, misses_per_s: float = 0.0) -> "Watched":
        for _ in range(round(seconds / LOOK)):
            self.now = round(self.now + LOOK, 3)
            present = [Present(name, failure="killed") for name in self.killed]
            present += [Present(n, pid, 1.0) for n, pid in self.running.items()]
            self.board.attend(present, self.ns)
            self.misses += round(misses_per_s * LOOK)
            for name in sorted(self.says):
                self._speak(name)
            self.board.refresh(self.ns)
        return self

    def end(self, *names: str) -> None:
        """Let nodes end in order: they say so, then they are gone from the registry."""
        for name in names:
            self.status(name, Lifecycle.FINALIZED)
            self.says.discard(name)
            self.running.pop(name)

    def kill(self, name: str) -> None:
        """Let a node die: it says nothing, and the registry has found its process dead."""
        self.says.discard(name)
        self.running.pop(name)
        self.killed.add(name)

    def status(self, name: str, state: Lifecycle = Lifecycle.ACTIVE) -> None:
        self._seq += 1
        rate = 500.0 if name != RECORD else 0.0
        self.board.receive(
            NodeStatus(
                self.ns,
                name,
                self._seq,
                state,
                500.0,
                rate,
                latency_p50=200.0 if name == GRASP else math.nan,
                deadline_misses=self.misses if name in self.late else 0,
                rejected=dict(self.rejected),
            ),
            self.ns,
            name,
        )

    @property
    def ns(self) -> int:
        return round(self.now * NS)

    def _speak(self, name: str) -> None:
        if round(self.now / LOOK) % 10 == 0:
            self.status(name)
        if name != GRASP:
            return
        for finger in self.board.fingers:
            margin = SlipMargin(self.ns, finger, 0, Estimate(0.5, 0.1, True, 0.0), 0.4, 0.95)
            grip = ForceCommand(self.ns, finger, 0, 2.0, 0.0, Reason.HOLD, self.ns + NS)
            for message in (margin, grip, health(self.condition, finger)):
                self.board.receive(message, self.ns, name)


def test_the_newest_message_of_each_kind_is_kept() -> None:
    board = Board(0)
    board.receive(FingertipState(1, "index", 1, normal_force=1.0), 1)
    board.receive(FingertipState(2, "index", 2, normal_force=2.0), 2)
    board.receive(SlipMargin(2, "index", 1, Estimate(0.5, 0.1, True, 0.0), 0.4, 0.95), 2)
    row = board.rows["index"]
    state = row.newest(FingertipState)
    assert state is not None
    assert state.normal_force == 2.0
    assert row.newest(SlipMargin) is not None
    assert row.newest(ContactEstimate) is None


def test_every_kind_has_an_age_of_its_own() -> None:
    board = Board(0)
    board.receive(SlipMargin(0, "index", 1, Estimate(0.5, 0.1, True, 0.0), 0.4, 0.95), 0)
    board.receive(command(1, Reason.HOLD), 6 * NS)
    row = board.rows["index"]
    assert row.age(SlipMargin, 6 * NS) == 6.0
    assert row.fresh(SlipMargin, 6 * NS) is None
    assert row.fresh(ForceCommand, 6 * NS) is not None
    assert row.age(ContactEstimate, 6 * NS) == math.inf


def test_nothing_is_fresh_after_half_a_second() -> None:
    board = Board(0)
    board.receive(command(1, Reason.HOLD), 0)
    row = board.rows["index"]
    assert row.fresh(ForceCommand, round(0.5 * NS)) is not None
    assert row.fresh(ForceCommand, round(0.5 * NS) + 1) is None


def test_a_margin_said_again_is_as_old_as_what_it_rests_on() -> None:
    board = Board(0)
    board.receive(SlipMargin(0, "index", 1, Estimate(0.5, 0.1, False, age=3.0), 0.4, 0.95), 0)
    assert board.rows["index"].fresh(SlipMargin, 0) is None
    assert board.rows["index"].age(SlipMargin, NS) == 4.0


def test_a_contact_is_as_old_as_its_youngest_estimate() -> None:
    board = Board(0)
    old, young = Estimate(1.0, 0.1, True, age=9.0), Estimate(1e-3, 1e-5, True, age=0.1)
    board.receive(ContactEstimate(0, "index", 0, normal_force=old, indentation=young), 0)
    assert board.rows["index"].age(ContactEstimate, 0) == 0.1


def test_health_that_comes_seldom_is_fresh_until_the_next_is_overdue() -> None:
    board = Board(0)
    for second in (0, 2, 4):
        board.receive(health(Condition.OK), second * NS)
    assert board.rows["index"].fresh(ModelHealth, 6 * NS) is not None
    assert board.rows["index"].fresh(ModelHealth, 7 * NS) is None


def test_a_slip_is_said_once_until_it_is_over() -> None:
    board = Board(0)
    for seq, reason in enumerate((Reason.HOLD, Reason.SLIP, Reason.SLIP, Reason.HOLD, Reason.SLIP)):
        board.receive(command(seq, reason), seq)
    assert texts(board) == ["index: slip detected, grip raised"] * 2


def through(conditions: Iterable[tuple[float, Condition]], until: float) -> Board:
    """Return a board that was told ``conditions`` at their times [s], looked at ten times a second."""
    board, left = Board(0), list(conditions)
    for i in range(round(until / LOOK) + 1):
        while left and left[0][0] <= i * LOOK:
            board.receive(health(left.pop(0)[1]), round(i * LOOK * NS))
        board.refresh(round(i * LOOK * NS))
    return board


def test_a_largest_force_that_may_not_suffice_is_said_before_it_is_reached_and_when_it_does_again() -> None:
    board = Board(0)
    for limit in ("", "near", "near", "reached", "near", ""):
        board.receive(ModelHealth(0, "index", 0, Condition.OK, limit=limit), 0)
    assert texts(board) == [
        "index: half as much load again needs more than the largest force",
        "index: more is needed than the largest force",
        "index: the largest force suffices again",
    ]


def test_input_that_ceases_and_comes_back_is_said() -> None:
    board = through([(1, Condition.OK), (2, Condition.STALE), (4, Condition.OK)], until=6)
    assert texts(board) == ["index: input stale", "index: input ok"]
    assert [round(line.time) for line in board.log] == [3, 5]
    assert [line.style for line in board.log] == ["red", "green"]


def test_a_gap_shorter_than_half_a_second_is_not_said() -> None:
    assert not through([(1, Condition.OK), (2, Condition.STALE), (2.4, Condition.OK)], until=6).log


@pytest.mark.parametrize("condition", [Condition.CORRUPT, Condition.FROZEN, Condition.REPLAYED])
def test_bad_data_is_said_at_once(condition: Condition) -> None:
    board = through([(1, Condition.OK), (2, condition)], until=2)
    assert texts(board) == [f"index: input {condition.name.lower()}"]


def test_a_hand_that_has_not_begun_is_no_alarm() -> None:
    board = through([(1, Condition.MISSING), (2, Condition.STALE), (9, Condition.OK)], until=12)
    assert not board.log


def test_several_fingers_that_cease_together_are_one_line() -> None:
    watched = Watched(("thumb", "index", "ring")).pass_by(2.0)
    watched.condition = Condition.STALE
    watched.pass_by(2.0)
    assert texts(watched.board) == ["all fingers: input stale"]


def test_made_up_names_do_not_make_it_grow() -> None:
    board = Board(0)
    for i in range(10 * MOST_FINGERS):
        board.receive(ContactEstimate(i, f"finger {i}", i), i)
        board.receive(NodeStatus(i, f"node {i}", 1, Lifecycle.ACTIVE), i)
    assert len(board.rows) == MOST_FINGERS
    assert len(board.nodes) == 64


def test_fingers_are_in_the_order_of_the_hand_whichever_is_heard_first() -> None:
    board = Board(0)
    board.receive(ContactEstimate(0, "ring", 0), 0)
    board.attend([Present(GRASP, fingers=("thumb", "index", "ring"))], 0)
    board.receive(ContactEstimate(0, "index", 0), 0)
    assert list(board.rows) == ["thumb", "index", "ring"]


def test_a_good_run_says_nothing() -> None:
    watched = Watched().pass_by(30.0)
    assert not watched.board.log
    assert {row.presence for row in watched.board.nodes.values()} == {Presence.RUNNING}


@pytest.mark.parametrize("end", [(GRASP, HAND, RECORD), (RECORD, HAND, GRASP), (HAND, GRASP, RECORD)])
def test_an_end_in_order_is_no_alarm_whoever_ends_first(end: tuple[str, ...]) -> None:
    watched = Watched(("thumb", "index")).pass_by(5.0)
    for name in end:
        watched.end(name)
        if name == HAND:
            watched.condition = Condition.STALE
        watched.pass_by(0.7)
    watched.pass_by(10.0)
    assert not alarms(watched.board)
    assert {row.presence for row in watched.board.nodes.values()} == {Presence.STOPPED}
    assert [text for text in texts(watched.board) if "stopped" in text]


def test_an_end_in_order_is_no_alarm_though_its_last_word_is_lost() -> None:
    watched = Watched().pass_by(5.0)
    watched.says.discard(RECORD)
    watched.running.pop(RECORD)
    watched.pass_by(5.0)
    assert not alarms(watched.board)
    assert texts(watched.board) == [f"{RECORD} has stopped"]


def test_a_stopped_node_that_streams_is_silent_after_half_a_second() -> None:
    watched = Watched().pass_by(5.0)
    watched.says.discard(GRASP)
    watched.pass_by(FRESH)
    assert watched.board.nodes[GRASP].presence is Presence.RUNNING
    watched.pass_by(2 * LOOK)
    assert watched.board.nodes[GRASP].presence is Presence.SILENT
    assert texts(watched.board) == [f"{GRASP} is silent since 5.0 s"]


def test_a_node_that_says_only_how_it_is_is_silent_when_two_such_have_not_come() -> None:
    watched = Watched().pass_by(5.0)
    watched.says.discard(RECORD)
    watched.pass_by(2.4)
    assert watched.board.nodes[RECORD].presence is Presence.RUNNING
    assert watched.board.nodes[RECORD].is_overdue(watched.ns)
    watched.pass_by(0.3)
    assert watched.board.nodes[RECORD].presence is Presence.SILENT


@pytest.mark.parametrize("name", [GRASP, HAND, RECORD])
def test_a_killed_node_is_gone_within_half_a_second(name: str) -> None:
    watched = Watched().pass_by(5.0)
    watched.kill(name)
    watched.pass_by(FRESH)
    assert watched.board.nodes[name].presence is Presence.GONE
    assert f"{name} has died, last received at 5.0 s: killed" in texts(watched.board)


def test_what_a_killed_node_said_last_of_the_input_is_not_said_after_it() -> None:
    watched = Watched().pass_by(5.0)
    watched.condition = Condition.STALE
    watched.pass_by(0.1)
    watched.kill(GRASP)
    watched.pass_by(5.0)
    assert texts(watched.board) == [f"{GRASP} has died, last received at 5.1 s: killed"]
    watched.board.log.clear()
    watched.condition = Condition.OK
    watched.running[GRASP] = 99
    watched.says.add(GRASP)
    watched.pass_by(2.0)
    assert texts(watched.board) == [f"{GRASP} is received again"]


@pytest.mark.parametrize("name", [GRASP, HAND, RECORD])
def test_no_node_looks_alive_that_says_nothing(name: str) -> None:
    watched = Watched().pass_by(5.0)
    watched.says.discard(name)
    for _ in range(100):
        watched.pass_by(1.0)
    assert watched.board.nodes[name].presence is Presence.SILENT


@pytest.mark.parametrize(("start", "said"), [(0.5, "is received again"), (8.0, "has started")])
def test_a_node_started_again_is_running_again_and_the_log_says_so(start: float, said: str) -> None:
    watched = Watched().pass_by(5.0)
    watched.kill(GRASP)
    watched.pass_by(1.0)
    watched.running[GRASP] = 99
    watched.pass_by(start)
    assert watched.board.nodes[GRASP].presence is not Presence.RUNNING  # it has not said anything
    watched.says.add(GRASP)
    watched.pass_by(1.0)
    assert watched.board.nodes[GRASP].presence is Presence.RUNNING
    assert texts(watched.board)[-1] == f"{GRASP} {said}"


def test_a_node_started_after_an_end_in_order_runs() -> None:
    watched = Watched().pass_by(5.0)
    watched.end(RECORD)
    watched.pass_by(1.0)
    watched.running[RECORD] = 99
    watched.says.add(RECORD)
    watched.pass_by(2.0)
    assert watched.board.nodes[RECORD].presence is Presence.RUNNING


def test_a_node_that_says_nothing_after_its_start_is_starting() -> None:
    watched = Watched().pass_by(1.0)
    watched.running["/late"] = 7
    watched.pass_by(5.0)
    row = watched.board.nodes["/late"]
    assert row.presence is Presence.STARTING
    assert row.age(watched.ns) == pytest.approx(4.9)


def test_a_watcher_that_slept_itself_calls_nobody_silent() -> None:
    watched = Watched().pass_by(5.0)
    watched.now += 60.0
    watched.board.refresh(watched.ns)
    assert not alarms(watched.board)
    watched.pass_by(5.0)
    assert not alarms(watched.board)


def test_a_node_of_another_machine_needs_no_registry() -> None:
    watched = Watched()
    watched.running.clear()
    watched.pass_by(5.0)
    assert watched.board.nodes[GRASP].presence is Presence.RUNNING
    watched.says.discard(GRASP)
    watched.pass_by(2.0)
    assert watched.board.nodes[GRASP].presence is Presence.SILENT


def test_a_machine_too_busy_is_called_so_while_it_is() -> None:
    watched = Watched().pass_by(5.0)
    assert watched.board.busy == ""
    watched.pass_by(5.0, misses_per_s=20.0)
    assert "this machine is busy: 4 %" in watched.board.busy
    watched.pass_by(5.0, misses_per_s=100.0)
    assert watched.board.busy == (f"this machine is too busy: 20 % of the commands of {GRASP} are late")
    watched.pass_by(5.0)
    assert watched.board.busy == ""


def test_a_hand_with_late_ticks_is_not_said_to_command_late() -> None:
    watched = Watched()
    watched.late = (HAND,)
    watched.pass_by(5.0).pass_by(5.0, misses_per_s=100.0)
    assert watched.board.nodes[HAND].late == pytest.approx(100.0)
    assert watched.board.busy == ""


def test_a_refusal_is_news_for_ten_seconds_and_what_was_before_is_not() -> None:
    watched = Watched()
    watched.rejected = {"error_frame": 8000}
    watched.pass_by(5.0)
    row = watched.board.nodes[GRASP]
    assert row.refusals(watched.ns) == {}
    watched.rejected = {"error_frame": 8000, "checksum": 3}
    watched.pass_by(2.0)
    assert row.refusals(watched.ns) == {"checksum": 3}
    watched.pass_by(11.0)
    assert row.refusals(watched.ns) == {}


def test_as_json_has_ages_no_nan_and_names_for_enumerations() -> None:
    board = Board(0)
    board.receive(ContactEstimate(1, "index", 1), 0)
    board.receive(command(1, Reason.FAIL_SAFE), 6 * NS)
    board.receive(NodeStatus(1, "/grasp", 1, Lifecycle.ACTIVE, latency_max=math.inf), 6 * NS, "/grasp")
    board.refresh(7 * NS)
    read = json.loads(json.dumps(as_json(board, 7 * NS), allow_nan=False))
    finger = read["fingers"]["index"]
    assert finger["command"]["reason"] == "FAIL_SAFE"
    assert finger["contact"]["contact_radius"]["std"] is None
    assert (finger["contact"]["age"], finger["contact"]["fresh"]) == (7.0, False)
    assert finger["command"]["age"] == 1.0
    assert read["nodes"]["/grasp"]["state"] == "ACTIVE"
    assert (read["nodes"]["/grasp"]["presence"], read["nodes"]["/grasp"]["age"]) == ("running", 1.0)
