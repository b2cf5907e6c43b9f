"""The table shows what is on the board, and shows that something is missing."""

import math
from typing import Any

import pytest
from rich.console import Console

from vegrip.clock import NS
from vegrip.messages import (
    BEYOND_FIT,
    PROBED,
    Condition,
    ContactEstimate,
    DeviceReport,
    Estimate,
    FingertipState,
    ForceCommand,
    Lifecycle,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)
from vegrip.runtime.monitor.board import Board, as_json
from vegrip.runtime.monitor.rows import Present
from vegrip.runtime.monitor.table import BAR, finger_lines, render, spoken
from vegrip.web.live.alarms import health_in_words


def text(board: Board, now: int = 1, width: int = 150, height: int = 40) -> str:
    console = Console(width=width)
    board.refresh(now)
    with console.capture() as capture:
        console.print(render(board, now, size=(width, height)))
    return capture.get()


def rows_of(board: Board, now: int, width: int) -> list[str]:
    return [line for line in text(board, now, width).splitlines() if "index" in line]


def known(value: float, std: float = 0.0) -> Estimate:
    return Estimate(value, std, True, 0.0)


@pytest.fixture
def board() -> Board:
    board = Board(0, ("index", "ring"))
    contact = ContactEstimate(
        1,
        "index",
        1,
        in_contact=True,
        contact_radius=known(5.1e-3, 4e-5),
        pressure_exponent=known(2.53, 0.12),
        friction_coefficient=known(0.81, 0.07),
    )
    for message in (
        FingertipState(1, "index", 1, normal_force=3.456),
        contact,
        SlipMargin(1, "index", 1, known(0.62, 0.05), 0.5, 0.95),
        ForceCommand(1, "index", 1, 3.6, 0.1, Reason.FORECAST, 2 * NS),
        ModelHealth(1, "index", 1, Condition.OK, 1.0, consistent=True),
        status(0),
        status(1, rejected={"checksum": 3}),
    ):
        board.receive(message, 1)
    return board


def status(seq: int, state: Lifecycle = Lifecycle.ACTIVE, **more: Any) -> NodeStatus:
    return NodeStatus(1, "grasp_force", seq, state, 2500.0, 2501.0, 180.0, 420.0, 900.0, **more)


def test_a_row_has_force_contact_margin_command_and_health(board: Board) -> None:
    row = next(line for line in text(board).splitlines() if "index" in line)
    for cell in ("3.46", "5.10±0.04", "2.53±0.12", "0.81±0.07", "0.62", "3.60", "forecast", "ok"):
        assert cell in row


def test_what_a_device_says_of_its_contact_stands_beside_ours_while_it_is_news(board: Board) -> None:
    assert "its F" not in text(board)
    board.receive(DeviceReport(1, "index", 1, friction=0.77, grip_force=4.32), 1)
    assert "0.77  4.32" in rows_of(board, 1, 150)[0]
    assert "4.32" not in rows_of(board, NS, 150)[0]
    assert "4.32" not in rows_of(board, 1, 100)[0]  # gives way on a narrow terminal
    assert as_json(board, 1)["fingers"]["index"]["device"]["grip_force"] == 4.32


def test_the_bar_is_as_long_as_the_margin_and_marks_its_bound(board: Board) -> None:
    row = next(line for line in text(board).splitlines() if "index" in line)
    full, bound = round(0.62 * BAR), round(0.5 * BAR)
    assert "█" * bound + "|" + "█" * (full - bound - 1) + "·" in row


def test_what_is_not_known_is_a_dash(board: Board) -> None:
    row = next(line for line in text(board).splitlines() if "ring" in line)
    assert row.count("-") >= 5


def test_latency_and_refusals_of_a_node_are_shown(board: Board) -> None:
    row = next(line for line in text(board).splitlines() if "grasp_force" in line)
    for cell in ("active", "2500", "180 / 420 / 900", "checksum 3"):
        assert cell in row


def test_that_nothing_is_refused_now_is_said_only_of_two_statuses(board: Board) -> None:
    said = []
    for seq in (7, 8):
        status = NodeStatus(seq, "/late", seq, Lifecycle.ACTIVE, 500.0, 500.0, rejected={"counter": 31})
        board.receive(status, seq * NS)
        said.append(next(line for line in text(board).splitlines() if "/late" in line))
    assert "31 since its start" in said[0]
    assert "none now (31 before)" in said[1]


@pytest.mark.parametrize("margin", [math.nan, -0.4, 0.0, 1.0, 7.0])
@pytest.mark.parametrize("bound", [math.nan, -math.inf, -0.5, 1.0])
def test_no_margin_breaks_the_bar(board: Board, margin: float, bound: float) -> None:
    board.receive(SlipMargin(2, "index", 2, known(margin), bound, 0.95), 2)
    assert "index" in text(board)


@pytest.mark.parametrize("width", [80, 100, 150])
def test_bound_command_reason_and_health_are_there_at_every_width(board: Board, width: int) -> None:
    (row,) = rows_of(board, 1, width)
    for cell in ("0.62", "0.50", "3.60", "forecast", "ok"):
        assert cell in row


@pytest.mark.parametrize("width", [80, 150])
def test_what_is_older_than_half_a_second_is_blank_and_says_for_how_long(board: Board, width: int) -> None:
    (row,) = rows_of(board, 6 * NS, width)
    assert "no news 6 s" in row
    for cell in ("3.46", "5.10", "0.62", "0.50", "3.60", "forecast", "ok", "█"):
        assert cell not in row


def test_each_number_is_blank_by_its_own_age(board: Board) -> None:
    board.receive(ForceCommand(6 * NS, "index", 2, 4.2, 0.0, Reason.FAIL_SAFE, 7 * NS), 6 * NS)
    (row,) = rows_of(board, 6 * NS, 80)
    assert "no news 6 s" in row
    assert "4.20 fail safe" in row


def test_a_node_without_news_is_called_silent_with_its_age_and_its_figures_are_gone(board: Board) -> None:
    for tenth in range(40):
        board.refresh(tenth * NS // 10)
    row = next(line for line in text(board, 4 * NS).splitlines() if "grasp_force" in line)
    assert "silent" in row
    assert "active" not in row
    assert "2500" not in row


@pytest.mark.parametrize("word", ["gone", "stopped"])
def test_a_node_that_is_no_more_is_called_so(board: Board, word: str) -> None:
    board.attend([Present("grasp_force", 1)], 1)
    board.attend([Present("grasp_force", failure="killed")] if word == "gone" else [], 2)
    row = next(line for line in text(board, 4 * NS).splitlines() if "grasp_force" in line)
    assert f"{word} 4 s" in row
    assert "active" not in row


def test_at_60_columns_health_is_there_and_nothing_is_wider(board: Board) -> None:
    board.receive(ModelHealth(1, "ring", 1, Condition.STALE), 1)
    lines = text(board, 1, 60).splitlines()
    (row,) = (line for line in lines if "index" in line)
    for cell in ("0.62", "0.50", "3.60", "ok"):
        assert cell in row
    assert {len(line) for line in lines} == {60}


@pytest.mark.parametrize("margin", [-0.1, 0.02])
def test_a_margin_that_is_small_because_friction_is_probed_is_no_red_bar(board: Board, margin: float) -> None:
    board.receive(SlipMargin(1, "index", 2, known(margin), -0.3, 0.95), 1)
    board.receive(ModelHealth(1, "index", 2, Condition.OK, 1.0, consistent=True, friction=PROBED), 1)
    console = Console(width=100, force_terminal=True, color_system="standard")
    with console.capture() as capture:
        console.print(render(board, 1, size=(100, 40)))
    row = next(line for line in capture.get().splitlines() if "index" in line)
    assert "probing friction" in row
    assert "\x1b[31m" not in row


def test_a_contact_beyond_what_the_model_was_fitted_over_is_said_though_nothing_fails(board: Board) -> None:
    beyond = ModelHealth(1, "index", 2, Condition.OK, 1.0, True, "normal_force", BEYOND_FIT)
    board.receive(beyond, 1)
    (row,) = rows_of(board, 1, 150)
    assert "beyond the fit: normal_force" in row
    assert health_in_words(beyond) == "normal force is beyond the range over which the model was fitted"


def test_before_a_node_it_says_what_it_waits_for() -> None:
    assert "waits for one; `vegrip launch demo` starts" in text(Board(0))


def test_into_a_file_goes_a_line_for_each_finger_that_says_something(board: Board) -> None:
    (line,) = finger_lines(board, 2)
    assert line == "   0.00 s  index: N 3.46 N, margin 0.62, bound 0.50, F 3.60 N forecast, ok"
    assert finger_lines(board, 6 * NS) == []


def test_a_screen_of_80_columns_and_24_lines_holds_it_all(board: Board) -> None:
    for finger in ("thumb", "middle", "little"):
        board.receive(
            ModelHealth(
                1, finger, 1, Condition.OK, 9.0, channel="tangential_force_x", regime="deep holding, slow"
            ),
            1,
        )
    board.attend([Present(name, 1) for name in ("/a_node_of_a_long_name", "/record", "/virtual_hand")], 1)
    for i in range(8):
        board.say(f"something happened that takes more than one line to tell in full, number {i}", 1)
    lines = text(board, 2, 80, 24).rstrip("\n").splitlines()
    assert len(lines) <= 24
    assert max(len(line) for line in lines) == 80
    assert "something happened" in lines[-2]
    assert all("ok" in line or "misfit" in line for line in lines if "index" in line or "thumb" in line)


def test_a_busy_machine_is_named_while_it_is_busy(board: Board) -> None:
    board.receive(status(2, deadline_misses=2000), NS)
    assert "this machine is too busy: 80 % of the commands of grasp_force are late" in text(board, NS, 80)


@pytest.mark.parametrize(
    ("age", "words"), [(0.04, "0.0 s"), (0.72, "0.7 s"), (6.2, "6 s"), (130.0, "2 min"), (7300.0, "2 h")]
)
def test_an_age_is_short(age: float, words: str) -> None:
    assert spoken(age) == words


def test_friction_that_is_probed_on_purpose_is_said_in_place_of_a_red_bar(board: Board) -> None:
    board.receive(SlipMargin(1, "index", 2, known(0.3, 0.2), -0.1, 0.95), 1)
    for friction, said in (("probed", "probing friction"), ("known", "friction known")):
        board.receive(ModelHealth(1, "index", 2, Condition.OK, 1.0, consistent=True, friction=friction), 1)
        assert said in text(board)
    console = Console(width=150, force_terminal=True, color_system="standard")
    with console.capture() as capture:
        console.print(render(board, 1, size=(150, 40)))
    assert "\x1b[31m█" not in capture.get()


def test_a_largest_force_that_does_not_suffice_or_may_not_is_said_in_the_health(board: Board) -> None:
    for limit, said in (("near", "near the largest force"), ("reached", "more than the largest force")):
        told = ModelHealth(1, "index", 2, Condition.OK, 1.0, consistent=True, friction="known", limit=limit)
        board.receive(told, 1)
        assert said in rows_of(board, 1, 150)[0]
