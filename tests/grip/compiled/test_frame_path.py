"""What is done with a frame, packet or batch, by what the node did with it: of a node that only says so."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vegrip.grip.frame_path import BatchPath, FramePath, PacketPath
from vegrip.grip.wires import COMMANDED, LEFT_ALONE, REPORT
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, SlipMargin
from vegrip.runtime.telemetry import Direction
from vegrip.transport.codec import Frame

TAKEN = 1  # and nothing to send
FINGERS = {"thumb": (16, 32), "index": (17, 33)}  # identifiers of states and commands
OUTCOMES = (LEFT_ALONE, TAKEN, COMMANDED, REPORT, TAKEN | COMMANDED | REPORT)
FIRST_ROW, CONTACT_ROW, MARGIN_ROW, COMMAND_ROW = 16, 66, 50, 26


class Told:
    """Notes what it is called with, by name."""

    def __init__(self, calls: list[Any], **answers: Any) -> None:
        self.calls, self.answers = calls, answers

    def __getattr__(self, name: str) -> Any:
        def call(*given: Any) -> Any:
            self.calls.append((name, *given))
            answer = self.answers.get(name)
            return answer(*given) if callable(answer) else answer

        return call


class Rig:
    """A path, and what it called of node, endpoint and loop."""

    def __init__(
        self,
        kind: type[FramePath],
        done: int = TAKEN,
        *,
        known: tuple[str, ...] | None = None,
        counts: bool | None = None,
        watched: tuple[str, ...] = (),
        ready: bool = True,
        is_on_line: bool = True,
    ) -> None:
        self.calls: list[Any] = []
        numbers = SimpleNamespace(
            felt=lambda: (3.0, 1.0), answer_frame=np.arange(3, dtype=np.uint8), state=lambda: "state",
            is_on_line=is_on_line, report_as_frames=lambda _: ready,
            on_wire=SimpleNamespace(report_ids=(7, 8, 9)),
            report_frames=tuple(np.full(2, i, dtype=np.uint8) for i in range(3)),
        )  # fmt: skip
        finger = SimpleNamespace(
            numbers=numbers, command=lambda: "command", reports=SimpleNamespace(are_due=lambda now: now > 9),
            number_from=lambda number: self.calls.append(("number_from", number)),
        )  # fmt: skip
        self.node = Told(self.calls, on_frame=done, reports=lambda name, _: iter([name]))
        self.node.fingers, self.node.batch, self.node.packets = dict.fromkeys(FINGERS, finger), None, None
        self.endpoint = Told(self.calls)
        self.endpoint.line = lambda name: SimpleNamespace(
            state_id=FINGERS[name][0], command_id=FINGERS[name][1]
        )
        self.endpoint.batches = Told(self.calls)
        self.endpoint.batches.lengths = {ContactEstimate: 64, SlipMargin: 48, ForceCommand: 24}
        telemetry = Told(self.calls, count=counts, wants=lambda k, name, _: (k, name) in watched)
        loop: Any = (
            SimpleNamespace(now=lambda: 5), Told(self.calls), Told(self.calls, has_turn="thumb".__eq__),
            None if counts is None else telemetry,
            None if known is None else SimpleNamespace(knows=known.__contains__),
        )  # fmt: skip
        self.path = kind(self.node, self.endpoint, loop)  # type: ignore[arg-type]
        self.path.prepare()
        self.calls.clear()

    def named(self, *names: str) -> list[Any]:
        return [call for call in self.calls if call[0] in names]


@pytest.mark.parametrize("done", OUTCOMES)
@pytest.mark.parametrize("finger", FINGERS)
def test_a_frame_is_answered_counted_and_told_as_the_step_says(done: int, finger: str) -> None:
    rig = Rig(FramePath, done)
    state_id, command_id = FINGERS[finger]
    answer = rig.path.answer(Frame(state_id, b"ab", True, 4))
    (call,) = rig.named("on_frame")
    assert (call[1], call[2][:2].tobytes(), *call[3:]) == (finger, b"ab", 2, 4, 5)
    assert answer == ((True, (finger,) if done & REPORT else ()) if done else None)
    assert rig.path.frames == (done != LEFT_ALONE)
    sent = [("send_frame", Frame(command_id, b"\0\1\2", True))]
    assert rig.named("send_frame") == (sent if done & COMMANDED else [])
    counted = ("answered", finger, 4, 5) if done & COMMANDED else ("state", finger, 4)
    assert rig.named("answered", "state") == ([counted] if done else [])
    assert len(rig.named("note_values")) == (done != LEFT_ALONE and finger == "thumb")


@pytest.mark.parametrize("frame", [Frame(99, b"ab", True, 4), Frame(16, b"ab", False, 4)])
def test_a_frame_of_others_or_a_classic_one_is_not_looked_at(frame: Frame) -> None:
    rig = Rig(FramePath)
    assert rig.path.answer(frame) is None
    assert rig.calls == []


def test_until_the_channels_of_a_finger_are_known_the_codec_keeps_its_frames() -> None:
    rig = Rig(FramePath, known=("thumb",))
    assert rig.path.answer(Frame(17, b"ab", True, 4)) is None
    assert rig.calls == [("leave_lines", "index")]
    assert rig.path.answer(Frame(16, b"ab", True, 4)) is not None
    assert not rig.path.knows_all()
    assert Rig(FramePath, known=("thumb", "index")).path.knows_all()
    assert Rig(FramePath).path.knows_all()


@pytest.mark.parametrize("counts", [True, False])
@pytest.mark.parametrize("done", [TAKEN, COMMANDED])
def test_telemetry_counts_each_message_and_shows_those_that_it_wants(counts: bool, done: int) -> None:
    rig = Rig(FramePath, done, counts=counts)
    rig.path.answer(Frame(16, b"ab", True, 4))
    counted = [("count", FingertipState, "thumb", Direction.IN), ("show", "state", Direction.IN)]
    if done & COMMANDED:
        counted += [("count", ForceCommand, "thumb", Direction.OUT), ("show", "command", Direction.OUT)]
    assert rig.named("count", "show") == [one for one in counted if counts or one[0] == "count"]


@pytest.mark.parametrize(
    "given",
    [{}, {"counts": True}, {"counts": True, "watched": ((SlipMargin, "index"),)}, {"ready": False},
     {"is_on_line": False}],
)  # fmt: skip
def test_reports_leave_as_frames_unless_somebody_reads_them_or_they_are_for_messages(given: Any) -> None:
    rig = Rig(FramePath, **given)
    as_frames = not given or set(given) == {"counts"}
    assert list(rig.path.reports(["index", "toe"], 9)) == [None] * as_frames
    frames = [Frame(7 + i, bytes([i, i]), True) for i in range(3)]
    assert rig.named("send_frames") == [("send_frames", frames)] * as_frames
    counted = [("count", kind, "index", Direction.OUT) for kind in (ContactEstimate, SlipMargin)]
    assert rig.named("count") == (counted if as_frames and given else [])
    assert list(rig.path.reports(["index"], 10)) == [*[None] * as_frames, "index"]


@pytest.mark.parametrize("kind", [FramePath, PacketPath, BatchPath])
def test_nothing_is_looked_at_without_a_guard_or_where_nothing_can_be_answered(kind: type[FramePath]) -> None:
    rig, name = Rig(kind), {FramePath: "", PacketPath: "_packet", BatchPath: "_batch"}[kind]
    rig.node.packets = object()
    for guard, given in ((lambda one: one, True), (None, False)):
        rig.path.look(guard)
        looks = vars(rig.endpoint)[f"intercept{name}"]
        assert looks == (getattr(rig.path, f"answer{name}") if given else None)
    rig.node.packets = None
    rig.endpoint.line = lambda _: None
    rig.path.prepare()
    rig.path.look(lambda one: one)
    assert vars(rig.endpoint)[f"intercept{name}"] is None


def test_commands_sent_in_its_place_are_numbered_on_for_fingers_that_are_there() -> None:
    rig = Rig(FramePath)
    rig.path.renumber({"thumb": 7, "toe": 8})
    assert rig.calls == [("number_from", 7)]


def test_a_packet_is_left_to_others_until_all_is_known_and_then_answered_state_by_state() -> None:
    rig = Rig(PacketPath, known=("thumb",))
    assert rig.path.answer_packet(b"", 3) is None  # type: ignore[attr-defined]
    assert rig.calls == []
    rig = Rig(PacketPath)
    assert rig.path.answer_packet(b"", 3) is None  # type: ignore[attr-defined]
    for commands in (0, 2):
        rig.calls.clear()
        states = [("thumb", COMMANDED, 4), ("index", TAKEN | REPORT, 5)]
        rig.node.answers["on_packet"] = lambda *_, n=commands, states=states: (
            "taken",
            n,
            b"requests",
            states,
        )
        assert rig.path.answer_packet(b"", 3) == ("taken", ["index"])  # type: ignore[attr-defined]
        assert rig.named("send_requests") == [("send_requests", b"requests", 2)] * (commands > 0)
        assert rig.named("answered", "state") == [("answered", "thumb", 4, 5), ("state", "index", 5)]


def test_rows_of_a_batch_are_shown_that_were_taken_and_commands_leave_sealed() -> None:
    rig = Rig(BatchPath, counts=True, known=("thumb",))
    assert rig.path.answer_batch(b"", 2, 4) is None  # type: ignore[attr-defined]
    assert rig.calls == [("leave_lines",)]
    rig, done = Rig(BatchPath, counts=True), bytearray([TAKEN, LEFT_ALONE, COMMANDED | REPORT, 0])
    assert rig.path.answer_batch(b"", 2, 4) is None  # type: ignore[attr-defined]
    rig.node.batch = SimpleNamespace(
        commands=bytearray(range(100)), names_in=lambda *_: ["index", "thumb", "thumb"]
    )
    assert rig.path.answer_batch(b"", 2, 4) is None  # type: ignore[attr-defined]
    rig.node.answers["on_batch"] = lambda *_: (done, 1)
    rig.calls.clear()
    assert rig.path.answer_batch(b"", 3, 4) == (done, ["thumb"])  # type: ignore[attr-defined]
    whole = bytearray(range(FIRST_ROW + COMMAND_ROW))
    assert rig.named("seal", "send_batch") == [
        ("seal", whole, ForceCommand, 1), ("send_batch", ForceCommand, whole),
    ]  # fmt: skip
    assert [call[2] for call in rig.named("count")] == ["index", "thumb", "thumb"]  # and its command
    assert rig.named("batch") == [("batch", 2, 1, 4, 5)]


@pytest.mark.parametrize("watched", [(), ((ContactEstimate, "index"),)])
def test_reports_of_a_batch_leave_sealed_but_those_that_somebody_reads(watched: Any) -> None:
    rig = Rig(BatchPath, counts=True, watched=watched)
    asked: list[list[str]] = []
    rig.node.batch = SimpleNamespace(
        contacts=bytearray(400), margins=bytearray(300), report=lambda names, _: asked.append(names) or names
    )
    assert list(rig.path.reports(["thumb", "index"], 9)) == [None]
    names = ["thumb"] if watched else ["thumb", "index"]
    assert asked == [names]
    put = [(call[1], len(call[2])) for call in rig.named("put_off_batch")]
    rows = len(names)
    assert put == [
        (ContactEstimate, FIRST_ROW + 2 * rows * CONTACT_ROW), (SlipMargin, FIRST_ROW + rows * MARGIN_ROW),
    ]  # fmt: skip
    assert [call[2:] for call in rig.named("seal")] == [(ContactEstimate, 2 * rows), (SlipMargin, rows)]
    assert [call[2] for call in rig.named("count")] == [name for name in names for _ in range(2)]
    rig.calls.clear()
    rig.node.batch.report = lambda *_: []
    assert list(rig.path.reports(["thumb"], 10)) == ["thumb"]
    rig.node.batch = None
    assert list(rig.path.reports(["thumb"], 10)) == ["thumb"]
    assert rig.named("put_off_batch", "seal", "count") == []
