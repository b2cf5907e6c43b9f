"""The board keeps the newest, notes what changes, and does not grow."""

import json
import math

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
from vegrip.monitor.board import MOST_FINGERS, Board, as_json


def command(seq: int, reason: Reason) -> ForceCommand:
    return ForceCommand(seq, "index", seq, 2.0, 0.0, reason, seq + NS)


def test_the_newest_message_of_each_kind_is_kept() -> None:
    board = Board(0)
    board.take(FingertipState(1, "index", 1, normal_force=1.0), 1)
    board.take(FingertipState(2, "index", 2, normal_force=2.0), 2)
    board.take(SlipMargin(2, "index", 1, Estimate(0.5, 0.1, True, 0.0), 0.4, 0.95), 2)
    row = board.rows["index"]
    assert row.state is not None
    assert row.state.normal_force == 2.0
    assert row.margin is not None
    assert row.contact is None


def test_a_slip_is_said_once_until_it_is_over() -> None:
    board = Board(0)
    for seq, reason in enumerate((Reason.HOLD, Reason.SLIP, Reason.SLIP, Reason.HOLD, Reason.SLIP)):
        board.take(command(seq, reason), seq)
    assert [line.text for line in board.log] == ["index: slip felt, grip raised"] * 2


def test_a_change_of_condition_is_said_with_its_time() -> None:
    board = Board(start=5 * NS)
    for second, condition in (
        (6, Condition.OK),
        (7, Condition.STALE),
        (8, Condition.STALE),
        (9, Condition.OK),
    ):
        board.take(ModelHealth(second * NS, "index", second, condition), second * NS)
    assert [(line.time, line.text) for line in board.log] == [
        (2.0, "index: input stale"),
        (4.0, "index: input ok"),
    ]


def test_made_up_names_do_not_make_it_grow() -> None:
    board = Board(0)
    for i in range(10 * MOST_FINGERS):
        board.take(ContactEstimate(i, f"finger {i}", i), i)
    assert len(board.rows) == MOST_FINGERS


def test_a_finger_that_says_nothing_is_silent() -> None:
    board = Board(0)
    board.take(command(1, Reason.HOLD), 0)
    assert not board.rows["index"].silent(NS // 4)
    assert board.rows["index"].silent(NS)


def test_as_json_has_no_nan_and_names_for_enumerations() -> None:
    board = Board(0)
    board.take(ContactEstimate(1, "index", 1), 1)
    board.take(command(1, Reason.FAIL_SAFE), 1)
    board.take(NodeStatus(1, "/grasp", 1, Lifecycle.ACTIVE, latency_max=math.inf), 1)
    read = json.loads(json.dumps(as_json(board), allow_nan=False))
    assert read["fingers"]["index"]["command"]["reason"] == "FAIL_SAFE"
    assert read["fingers"]["index"]["contact"]["contact_radius"]["std"] is None
    assert read["nodes"]["/grasp"]["state"] == "ACTIVE"
