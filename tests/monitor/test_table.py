"""The table shows what is on the board, and shows that something is missing."""

import math

import pytest
from rich.console import Console

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
from vegrip.monitor.board import Board
from vegrip.monitor.table import BAR, render


def text(board: Board, now: int = 1, width: int = 150) -> str:
    console = Console(width=width)
    with console.capture() as capture:
        console.print(render(board, now))
    return capture.get()


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
        NodeStatus(
            1,
            "grasp_force",
            1,
            Lifecycle.ACTIVE,
            2500.0,
            2501.0,
            180.0,
            420.0,
            900.0,
            rejected={"checksum": 3},
        ),
    ):
        board.take(message, 1)
    return board


def test_a_row_has_force_contact_margin_command_and_health(board: Board) -> None:
    row = next(line for line in text(board).splitlines() if "index" in line)
    for cell in ("3.46", "5.10±0.04", "2.53±0.12", "0.81±0.07", "0.62", "3.60", "forecast", "ok"):
        assert cell in row


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


@pytest.mark.parametrize("margin", [math.nan, -0.4, 0.0, 1.0, 7.0])
@pytest.mark.parametrize("bound", [math.nan, -math.inf, -0.5, 1.0])
def test_no_margin_breaks_the_bar(board: Board, margin: float, bound: float) -> None:
    board.take(SlipMargin(2, "index", 2, known(margin), bound, 0.95), 2)
    assert "index" in text(board)
