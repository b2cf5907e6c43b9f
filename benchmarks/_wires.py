"""A state on every wire, from its bytes to those of its command: as messages, or as the frames that came.

On both sides the codec and the node, without sockets, loop and reports; the same recorded states on all.
"""

import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Protocol

import cantools
import numpy as np

from validation.compiled_finger import Log
from vegrip.canopen.endpoint import CanopenCodec
from vegrip.canopen.network import identifiers
from vegrip.grip.node import GraspForce
from vegrip.grip.wires import COMMANDED
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID, BatchCodec
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.trials.candidates import demo_parameters, make_node

COMMAND_ROW = 24 + ROW_ID.size
GRASP_NODE, FIRST_FINGER = 16, 32
LONGEST_FRAME = 64
Given = tuple[Any, int]
"""What comes, and when [ns]."""


class Wire(Protocol):
    """One way of states and commands; ``given`` is made of the same states for all."""

    @property
    def given(self) -> Sequence[Given]:
        """What comes, in its order."""

    def by_messages(self, what: Any, now: int) -> None:
        """Answer what came as messages."""

    def compiled(self, what: Any, now: int) -> None:
        """Answer what came as it comes, where that goes without messages."""


def states_of(log: Log) -> list[tuple[FingertipState, int]]:
    """Return the states of a log of CAN FD frames, with their times [ns]."""
    codec = CanCodec(log.fingers, fd=True, use_sender_time=True)
    heard = [(codec.decode(event.frame), event.now) for event in log.events if event.frame is not None]
    return [(one, now) for one, now in heard if isinstance(one, FingertipState)]


def node_of(log: Log, lines: Any, mode: str) -> GraspForce:
    """Return an active node that never reports; without a ``mode`` states come as messages."""
    node = make_node(replace(demo_parameters(), report_period=10.0, health_period=60.0), log.fingers)
    node.configure()
    node.activate()
    if mode:
        node.run_compiled(lines, mode)
    return node


def commands(answers: Iterable[Message]) -> Iterable[ForceCommand]:
    """Yield the first command of the answers to one state; reports are made when they are taken."""
    for answer in answers:
        if isinstance(answer, ForceCommand):
            yield answer
            return


class Frames:
    """CAN FD frames, or classic ones, which are answered as messages."""

    def __init__(self, log: Log, mode: str, *, fd: bool) -> None:
        self.codec = CanCodec(log.fingers, fd=fd, use_sender_time=fd)
        lines = {finger: line for finger in log.fingers if (line := self.codec.line(finger)) is not None}
        self._known = {line.state_id: (finger, line.command_id) for finger, line in lines.items()}
        self.node = node_of(log, lines, mode)
        self._bytes = bytearray(LONGEST_FRAME)
        self._array = np.frombuffer(self._bytes, dtype=np.uint8)
        sender = CanCodec(log.fingers, fd=fd)
        self.given: list[Given] = [
            (frame._replace(stamp=now), now)
            for state, now in states_of(log)
            for frame in sender.encode(state)
        ]

    def by_messages(self, what: Frame, now: int) -> None:
        """Answer a frame by messages."""
        message = self.codec.decode(what)
        if message is not None:
            for command in commands(self.node.on_message(message, now)):
                self.codec.encode(command)

    def compiled(self, what: Frame, now: int) -> None:
        """Answer a frame as it comes."""
        if what.arbitration_id not in self._known:
            self.by_messages(what, now)
            return
        finger, command = self._known[what.arbitration_id]
        length = len(what.data)
        self._bytes[:length] = what.data
        if self.node.on_frame(finger, self._array, length, what.stamp, now) & COMMANDED:
            Frame(command, self.node.fingers[finger].numbers.answer_frame.tobytes(), True)


class Pdos(Frames):
    """Classic frames as the PDOs of CANopen."""

    def __init__(self, log: Log, mode: str) -> None:
        super().__init__(log, mode, fd=False)
        nodes = tuple(FIRST_FINGER + number for number in range(len(log.fingers)))
        known = identifiers(nodes, GRASP_NODE, 0)
        gates: Any = SimpleNamespace(accepts=lambda _: True, speaks=lambda _: True, keep=lambda *_: None)
        self._pdos = CanopenCodec(self.codec, known, gates)
        cob_ids = {identifier: cob_id for cob_id, identifier in known.items()}
        self.given = [
            (frame._replace(arbitration_id=cob_ids[frame.arbitration_id]), now) for frame, now in self.given
        ]

    def by_messages(self, what: Frame, now: int) -> None:
        """Answer a PDO by messages."""
        message = self._pdos.decode(what)
        if message is not None:
            for command in commands(self.node.on_message(message, now)):
                self._pdos.encode(command)

    compiled = by_messages


class SingleTopics:
    """msgpack on single topics."""

    def __init__(self, log: Log, mode: str) -> None:
        del mode
        self.codec = MsgpackCodec("", log.fingers)
        self.node = node_of(log, {}, "")
        sender = MsgpackCodec("", log.fingers)
        sent = [(sender.encode(state), now) for state, now in states_of(log)]
        self.given: list[Given] = [((one[0].encode(), one[1]), now) for one, now in sent if one is not None]

    def by_messages(self, what: tuple[bytes, bytes], now: int) -> None:
        """Answer a payload by messages."""
        message = self.codec.decode(what[0].decode("utf-8", "replace"), what[1], now)
        if message is not None:
            for command in commands(self.node.on_message(message, now)):
                self.codec.encode(command)

    compiled = by_messages


class Batches:
    """States of all fingers in one message, and their commands."""

    def __init__(self, log: Log, mode: str) -> None:
        self.codec = BatchCodec(log.fingers)
        lines = {finger: line for finger in log.fingers if (line := self.codec.line(finger)) is not None}
        self.node = node_of(log, lines, mode)
        sender, rows = BatchCodec(log.fingers), list[Frame]()
        self.given: list[Given] = []
        for state, now in states_of(log):
            rows += sender.encode(state)
            if len(rows) == len(log.fingers):
                self.given.append((bytes(sender.pack(FingertipState, rows)), now))
                rows = []

    def by_messages(self, what: bytes, now: int) -> None:
        """Answer a batch by messages."""
        frames: list[Frame] = []
        for row in range(self.codec.rows_in(what, FingertipState)):
            message = self.codec.decode(self.codec.frame(what, FingertipState, row, now))
            if message is not None:
                for command in commands(self.node.on_message(message, now)):
                    frames += self.codec.encode(command)
        self.codec.pack(ForceCommand, frames)

    def compiled(self, what: bytes, now: int) -> None:
        """Answer a batch by the compiled step."""
        answered = self.node.on_batch(what, self.codec.rows_in(what, FingertipState), now, now)
        batch = self.node.batch
        if answered is not None and answered[1] and batch is not None:
            data = batch.commands[: FIRST_ROW + answered[1] * COMMAND_ROW]
            self.codec.seal(data, ForceCommand, answered[1])


FOREIGN_DBC = """VERSION ""
BU_: Hand PC
{frames}"""
FOREIGN_FRAMES = """BO_ {state} State_{finger}: 8 Hand
 SG_ Fz_{finger} : 0|16@1- (0.002,0) [0|0] "N" PC
 SG_ Fx_{finger} : 16|16@1- (0.002,0) [0|0] "N" PC
 SG_ Fy_{finger} : 32|16@1- (0.002,0) [0|0] "N" PC
 SG_ Roll_{finger} : 48|16@1+ (1,0) [0|65535] "" PC
BO_ {command} Set_{finger}: 2 PC
 SG_ Grip_{finger} : 0|16@1+ (0.01,0) [0|50] "N" Hand
"""
FOREIGN_FINGER = """[messages.State_{finger}]
counter = "Roll_{finger}"
[fingers.{finger}.normal_force]
signal = "State_{finger}.Fz_{finger}"
noise = 0.01
[fingers.{finger}.tangential_force_x]
signal = "State_{finger}.Fx_{finger}"
zero_is_measured = true
noise = 0.01
[fingers.{finger}.tangential_force_y]
signal = "State_{finger}.Fy_{finger}"
zero_is_measured = true
noise = 0.01
[fingers.{finger}.command]
signal = "Set_{finger}.Grip_{finger}"
"""


class Foreign:
    """Frames of a hand of another make, behind a map: one frame of 8 bytes a state, one of 2 a command."""

    def __init__(self, log: Log, mode: str) -> None:
        del mode
        frames = [
            FOREIGN_FRAMES.format(finger=finger, state=64 + i, command=128 + i)
            for i, finger in enumerate(log.fingers)
        ]
        dbc = FOREIGN_DBC.format(frames="".join(frames))
        head = 'database = "foreign.dbc"\nrate = 200.0\n'
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "foreign.dbc").write_text(dbc, encoding="utf-8")
            path = Path(folder) / "hand.toml"
            fingers = [FOREIGN_FINGER.format(finger=finger) for finger in log.fingers]
            path.write_text(head + "".join(fingers), encoding="utf-8")
            self.codec = MappedCodec(open_plan(path))
        self.node = node_of(log, {}, "")
        database, counts = cantools.database.can.Database(), Counter[str]()
        database.add_dbc_string(dbc)
        self.given: list[Given] = []
        for state, now in states_of(log):
            finger = state.finger
            counts[finger] += 1
            forces = {
                "Fz": state.normal_force,
                "Fx": state.tangential_force_x,
                "Fy": state.tangential_force_y,
            }
            values = {f"{name}_{finger}": value for name, value in forces.items()}
            values[f"Roll_{finger}"] = counts[finger] % 65536
            data = database.encode_message(f"State_{finger}", values, strict=False)
            self.given.append((Frame(64 + log.fingers.index(finger), bytes(data), False, now), now))

    def by_messages(self, what: Frame, now: int) -> None:
        """Answer a frame; a map gives messages."""
        states = self.codec.decode_all(what)
        for answer in self.node.on_message(states[0], now) if states else ():
            self.codec.encode(answer)
            break  # the reports behind it are made when they are taken

    compiled = by_messages


WIRES: dict[str, Callable[[Log, str], Wire]] = {
    "wire_fd": lambda log, mode: Frames(log, mode, fd=True),
    "wire_classic": lambda log, mode: Frames(log, mode, fd=False),
    "wire_canopen": Pdos,
    "wire_topics": SingleTopics,
    "wire_batch": Batches,
    "wire_map": Foreign,
}
"""Row of the benchmark -> what makes one, of a log and of what runs the step ("": messages alone)."""


def work(wire: Wire, *, compiled: bool) -> Callable[[], None]:
    """Return what answers all that is given, either way."""
    answer = wire.compiled if compiled else wire.by_messages

    def run() -> None:
        for what, now in wire.given:
            answer(what, now)

    return run


def require_all_answered(wire: Wire, states: int) -> None:
    """Raise unless the compiled step answered what it was given."""
    node: GraspForce = wire.node  # type: ignore[attr-defined]
    noted = Counter({name: finger.memory["TURN_NOTED"] for name, finger in node.fingers.items()})
    if noted.total() < 0.95 * states:
        raise AssertionError(f"only {noted.total()} of {states} states were answered by the compiled step")
