"""The watch hears nodes over their telemetry sockets, as they come, go and come back."""

import io
import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import asdict
from pathlib import Path

import pytest
from rich.console import Console

from vegrip.cli import main
from vegrip.errors import UsageError
from vegrip.host.folders import runtime_folder
from vegrip.messages import Lifecycle, Message, NodeStatus, SlipMargin
from vegrip.runtime.monitor import watch as watching
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.rows import Presence
from vegrip.runtime.monitor.watch import Screen, Watch
from vegrip.runtime.registry import Entry, registered
from vegrip.runtime.telemetry import Direction
from vegrip.runtime.telemetry_socket import TelemetrySocket
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

PATIENCE = 20.0  # [s] of what must happen at last


@pytest.fixture(autouse=True)
def runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "r"))
    monkeypatch.setattr(watching, "REGISTRY_PERIOD", 0.0)


class Speaker:
    """A node that runs as far as others can tell: registered, with a telemetry socket."""

    def __init__(self, name: str, fingers: list[str]) -> None:
        namespace = name.rpartition("/")[0].strip("/")
        self.entry = Entry(name, "echo", namespace, fingers=fingers, status_period=0.5)
        self._stack = ExitStack()
        self._stack.enter_context(registered(self.entry))
        codec = MsgpackCodec(namespace)
        self._socket = self._stack.enter_context(closing(TelemetrySocket(self.entry.telemetry, codec)))

    def say(self, message: Message) -> None:
        self._socket.listen()
        self._socket.publish([(message, Direction.OUT)])

    def close(self) -> None:
        self._stack.close()


@pytest.fixture
def left() -> Iterator[Speaker]:
    with closing(Speaker("/left/grasp", ["thumb", "index"])) as speaker:
        yield speaker


def die(entry: Entry) -> None:
    """Leave what a node leaves that is killed."""
    (runtime_folder("nodes") / f"{entry.name.strip('/').replace('/', '.')}.node").write_text(
        json.dumps(asdict(entry))
    )


def until(happened: Callable[[], bool], watch: Watch, board: Board | Screen, say: Callable[[], None]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not happened() and time.monotonic() < deadline:
        say()
        watch.step(board)
        if isinstance(board, Board):
            board.refresh(time.monotonic_ns())
    assert happened()


def test_without_a_node_it_says_how_to_start_one() -> None:
    with pytest.raises(UsageError, match="vegrip launch demo"):
        Watch()


def test_fingers_stand_in_the_order_of_the_hand_with_their_namespace(left: Speaker) -> None:
    board = Board(time.monotonic_ns())
    with closing(Watch()) as watch:
        watch.step(board)
        assert list(board.rows) == ["left/thumb", "left/index"]
        row = board.rows["left/index"]
        until(
            lambda: row.newest(SlipMargin) is not None,
            watch,
            board,
            lambda: left.say(SlipMargin(time.monotonic_ns(), "index", 1)),
        )
        assert row.source == "/left/grasp"
        assert board.nodes["/left/grasp"].presence is Presence.RUNNING


def test_a_node_that_comes_later_goes_and_comes_back_is_followed(left: Speaker) -> None:
    board, seq = Board(time.monotonic_ns()), iter(range(1_000_000))

    def said_by(speaker: Speaker) -> Callable[[], None]:
        name = speaker.entry.name
        return lambda: speaker.say(NodeStatus(time.monotonic_ns(), name, next(seq), Lifecycle.ACTIVE))

    def presence() -> Presence:
        return board.nodes["/right/grasp"].presence

    with closing(Watch()) as watch:
        watch.step(board)
        for _ in range(2):
            right = Speaker("/right/grasp", ["thumb"])
            watch.step(board)
            until(lambda: presence() is Presence.RUNNING, watch, board, said_by(right))
            right.close()
            die(right.entry)
            until(lambda: presence() is Presence.GONE, watch, board, said_by(left))
    assert sum("has died" in line.text for line in board.log) == 2


def test_a_node_that_ends_in_order_has_stopped_though_its_last_word_is_lost(left: Speaker) -> None:
    board = Board(time.monotonic_ns())
    with closing(Watch()) as watch:
        watch.step(board)
        left.close()
        watch.step(board)
    board.refresh(time.monotonic_ns())
    assert board.nodes["/left/grasp"].presence is Presence.STOPPED


def test_without_a_terminal_lines_come_as_things_happen(left: Speaker) -> None:
    lines = io.StringIO()
    screen = Screen("monitor", console=Console(file=lines, force_terminal=False))
    screen.open()
    seq = iter(range(1_000_000))

    def say() -> None:
        left.say(SlipMargin(time.monotonic_ns(), "index", next(seq)))

    with closing(Watch()) as watch:
        until(lambda: "left/index: N" in lines.getvalue(), watch, screen, say)
        left.close()
        until(lambda: "/left/grasp has stopped" in lines.getvalue(), watch, screen, lambda: None)
    screen.close()


def test_once_prints_the_table_and_ends(
    left: Speaker, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vegrip.cli.monitor.STATUS_WAIT_S", 0.01)
    assert main(["monitor", "--once"]) == 0
    told = capsys.readouterr().out
    assert "left/thumb" in told
    assert "/left/grasp" in told
