"""What programs that misbehave do to a node on ZeroMQ: a real process that grips, and a hand of our own.

The hand is the least there can be: it measures what it was last commanded, a load, and noise. What counts is
whether its states still arrive, whether commands still come back, and what the node counts.
"""

import contextlib
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random
from unittest import mock

import msgpack
import zmq

from vegrip.errors import VegripError
from vegrip.messages import FingertipState, ForceCommand, Lifecycle, Message, NodeStatus, Reason
from vegrip.runtime.registry import Entry, ask, find_node
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER
from vegrip.transport.curve import resolve

FINGERS = ("thumb", "index")
LAUNCH = """
fingers = ["thumb", "index"]
transport = { kind = "zmq", publish = "ipc:grip", subscribe = ["ipc:hand"] }

[[node]]
program = "grasp_force"
loop.status_period = 0.1
loop.tick_period = 0.005
"""
STATE_PERIOD_S = 0.005  # [s] of the states
LOAD_N, FORCE_NOISE_N = 0.5, 0.01  # [N]
START_TIMEOUT_S = 120.0  # [s] at most until the node answers
SETTLE_S = 3.0  # [s] before each act
WATCH = 3.0  # [s] after it
BACK_WITHIN_S = 2.0  # [s] until every finger is believed and commanded again
FALLS = 0.05  # share by which a command may be below the least before the act
DOUBT = frozenset(
    {Reason.INPUT_HOLD, Reason.FAIL_SAFE}
)  # reasons of a command to a finger that is not believed


@dataclass(frozen=True)
class Act:
    """One row of the table; ``do`` returns when it is done."""

    name: str
    do: Callable[["Stage"], None]
    counted_as: str  # name in NodeStatus; "": it is counted nowhere
    behaviour: str


@dataclass
class Outcome:
    """What one act did."""

    counted: int
    back_after: float | None  # [s] None: never
    least: float  # [N] of the commands before and after it
    before: float
    most: float
    complaints: list[str]


class Stage:
    """The hand, its commands, and the node."""

    def __init__(self, context: zmq.Context[zmq.Socket[bytes]]) -> None:
        self.context = context
        self.publisher = context.socket(zmq.PUB)
        self.publisher.bind(resolve("ipc:hand"))
        self._commands = context.socket(zmq.SUB)
        self._commands.connect(resolve("ipc:grip"))
        self._commands.subscribe("")
        self._sender, self._reader = MsgpackCodec(), MsgpackCodec()
        self._chance = Random(0)  # noqa: S311
        self._force = dict.fromkeys(FINGERS, 2.0)
        self._next = time.monotonic()
        self.stamp_shift = self.seq = 0
        self.other_force = 0.0  # [N] a second hand of the same name has so much more, in turn with this one
        self.rejected: dict[str, int] = {}
        self.commands: list[tuple[float, ForceCommand]] = []
        self.entry: Entry | None = None

    def hold(self, seconds: float) -> list[tuple[float, ForceCommand]]:
        """Send states for ``seconds`` and return the commands that came, each with its time [s]."""
        self.commands = []
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            self._next = max(self._next + STATE_PERIOD_S, time.monotonic())
            for finger in FINGERS:
                self.send(self._state(finger))
            self.seq += 1
            self._hear(self._next)
        return self.commands

    def send(self, message: Message) -> None:
        """Publish a message as the hand does."""
        encoded = self._sender.encode(message)
        if encoded is not None:
            self.publisher.send_multipart([encoded[0].encode(), encoded[1]])

    def forge(self, state: FingertipState, **fields: object) -> None:
        """Publish ``state`` with other fields, whatever they are, under a good checksum."""
        topic, payload = self._sender.encode(state) or ("", b"")
        body = msgpack.unpackb(payload[P04_HEADER:]) | fields
        data = bytearray(P04_HEADER) + msgpack.packb(body)
        data[P04_COUNTER] = (body["seq"] & 0xFFFF).to_bytes(2, "big")
        route = self._sender.topics.outgoing(type(state), state.finger)
        P04.protect(data, route.data_id if route else 0)
        self.publisher.send_multipart([topic.encode(), bytes(data)])

    def next_state(self) -> FingertipState:
        """Return the state that the first finger would send next."""
        self.seq += 1
        return self._state(FINGERS[0])

    def node(self) -> Entry:
        """Return the node."""
        self.entry = self.entry or find_node("grasp_force")
        return self.entry

    def _state(self, finger: str) -> FingertipState:
        other = self.other_force if self.seq % 2 else 0.0
        force, load = self._force[finger] + other + self._noise(), LOAD_N + self._noise()
        stamp = time.monotonic_ns() + self.stamp_shift
        return FingertipState(stamp, finger, self.seq, force, load, self._noise(), 1e-5, slip=0.0)

    def _noise(self) -> float:
        return self._chance.gauss(0.0, FORCE_NOISE_N)

    def _hear(self, until: float) -> None:
        while (left := until - time.monotonic()) > 0.0:
            if not self._commands.poll(max(1, round(left * 1000))):
                continue
            topic, payload = self._commands.recv_multipart()
            message = self._reader.decode(topic.decode(), payload, time.monotonic_ns())
            if isinstance(message, ForceCommand):
                self._force[message.finger] = message.normal_force
                self.commands.append((time.monotonic(), message))
            elif isinstance(message, NodeStatus) and message.node.endswith("grasp_force"):
                self.rejected = dict(message.rejected)


# --- what strangers do


def _send_too_much(stage: Stage) -> None:
    stage.publisher.send_multipart([b"/hand/thumb/state", bytes(70_000)])


def _send_rubbish(stage: Stage) -> None:
    chance = Random(1)  # noqa: S311
    for _ in range(5000):
        stage.publisher.send_multipart([b"/hand/thumb/state", chance.randbytes(chance.randrange(200))])


def _send_parts(stage: Stage) -> None:
    for count in (1, 3, 100):
        stage.publisher.send_multipart([b"/hand/thumb/state"] * count)


def _send_wide_stamps(stage: Stage) -> None:
    for stamp in (1 << 63, (1 << 64) - 1):
        stage.forge(stage.next_state(), stamp=stamp)


def _jump_in_sequence(stage: Stage) -> None:
    state = stage.next_state()
    stage.forge(state, seq=(state.seq + (1 << 31)) % (1 << 32))


def _make_up_names(stage: Stage) -> None:
    for number in range(5000):
        stage.send(NodeStatus(0, f"stranger{number}", 0, Lifecycle.ACTIVE))
        if number % 500 == 0:
            time.sleep(0.05)  # the hand says nothing meanwhile


def _ask_in_many_frames(stage: Stage) -> None:
    with stage.context.socket(zmq.DEALER) as stranger:
        stranger.linger = 0
        stranger.connect(stage.node().control)
        for _ in range(20):
            stranger.send_multipart([b"", b"", b""])
            stranger.poll(1000)


def _send_to_telemetry(stage: Stage) -> None:
    with stage.context.socket(zmq.XSUB) as stranger:
        stranger.linger = 0
        stranger.connect(stage.node().telemetry)
        for message in (b"", b"\x00", b"\x00/hand", b"hello"):
            stranger.send(message)
        stage.hold(0.5)


def _connect_without_end(stage: Stage) -> None:
    path = stage.node().control.removeprefix("ipc://")
    with ExitStack() as crowd:
        with contextlib.suppress(OSError):  # no more are let in, or we have no more descriptors ourselves
            for _ in range(1500):
                crowd.enter_context(socket.socket(socket.AF_UNIX)).connect(path)
        stage.hold(1.0)


def _speak_as_two(stage: Stage) -> None:
    stage.other_force = 0.5
    stage.hold(2.0)
    stage.other_force = 0.0


HELD_UNTIL_REOPENED = "held until the connection is opened anew"
UNNOTICED = "no effect"
ACTS = (
    Act("5000 names are made up before the first state of the hand", _make_up_names, "crowded", UNNOTICED),
    Act("the hand sends a message of 70 000 bytes", _send_too_much, "cut_off", HELD_UNTIL_REOPENED),
    Act("5000 messages of random bytes", _send_rubbish, "checksum", UNNOTICED),
    Act("messages of 1, 3 and 100 parts", _send_parts, "parts", UNNOTICED),
    Act("stamps of 2^63 and 2^64 - 1", _send_wide_stamps, "value", UNNOTICED),
    Act("one counter that is 2^31 ahead", _jump_in_sequence, "counter", UNNOTICED),
    Act("two hands in turn, 0.5 N apart", _speak_as_two, "two_senders", "reported; both are believed"),
    Act("requests of three frames to the control socket", _ask_in_many_frames, "request", UNNOTICED),
    Act("an empty message to the telemetry socket", _send_to_telemetry, "subscription", UNNOTICED),
    Act("1500 connections to the control socket", _connect_without_end, "connections", UNNOTICED),
)


def perform(progress: Callable[[Act, Outcome], object], only: str = "") -> bool:
    """Do all acts named like ``only`` to one node, tell of each, and return whether all went as they must."""
    with _node_process() as process, zmq.Context() as context:
        context.linger = 0
        stage = Stage(context)
        _until_active(stage)
        well = True
        for act in [act for act in ACTS if only in act.name]:
            outcome = _perform(stage, act)
            if process.poll() is not None:
                outcome.complaints.append(f"the node ended with {process.returncode}")
            progress(act, outcome)
            well = well and not outcome.complaints
            if process.poll() is not None:
                break
        context.destroy(linger=0)
        return well


def _perform(stage: Stage, act: Act) -> Outcome:
    settled = [] if act is ACTS[0] else stage.hold(SETTLE_S)  # before the first act no state has been sent
    before = min((command.normal_force for _, command in settled[len(settled) // 2 :]), default=0.0)
    known = stage.rejected.get(act.counted_as, 0)
    act.do(stage)
    began = time.monotonic()
    after = stage.hold(WATCH)
    forces = [command.normal_force for _, command in after] or [0.0]
    back = _back_after(after, began)
    counted = stage.rejected.get(act.counted_as, 0) - known
    outcome = Outcome(counted, back, min(forces), before, max(forces), [])
    if not counted:
        outcome.complaints.append(f"it is not counted as {act.counted_as}")
    if back is None or back > BACK_WITHIN_S:
        outcome.complaints.append(f"not every finger is commanded again within {BACK_WITHIN_S:g} s")
    if outcome.least < (1.0 - FALLS) * before:
        outcome.complaints.append(f"the command fell from {before:.2f} to {outcome.least:.2f} N")
    try:
        ask(stage.node(), "state", patience=10.0)
    except VegripError as error:
        outcome.complaints.append(str(error))
    return outcome


def _back_after(commands: list[tuple[float, ForceCommand]], began: float) -> float | None:
    """Return when the last finger was believed again [s], for good; None: never."""
    last: dict[str, ForceCommand | None] = {finger: None for finger in FINGERS}  # noqa: C420 (typed)
    last |= {command.finger: command for _, command in commands}
    if any(command is None or command.reason in DOUBT for command in last.values()):
        return None
    doubts = [at for at, command in commands if command.reason in DOUBT]
    return max(0.0, (max(doubts) if doubts else began) - began)


def _until_active(stage: Stage) -> None:
    ends = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < ends:
        with contextlib.suppress(VegripError):
            if ask(stage.node(), "state")["state"] == "active":
                return
        time.sleep(0.1)
    raise VegripError(f"the node does not turn active within {START_TIMEOUT_S:g} s")


@contextmanager
def _node_process() -> Iterator[subprocess.Popen[bytes]]:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="vg-")))
        stack.enter_context(mock.patch.dict(os.environ, VEGRIP_RUNTIME_DIR=str(folder / "r")))
        file = folder / "strangers.toml"
        file.write_text(LAUNCH, encoding="utf-8")
        command = [sys.executable, "-m", "vegrip", "launch", str(file)]
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            yield process
        finally:
            process.terminate()
            process.wait()
