"""A batch is answered as its rows one by one, byte for byte, and the loop answers it in one call."""

import time
from contextlib import closing
from dataclasses import replace
from itertools import groupby, permutations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from validation.compiled_finger import Log
from vegrip.clock import WallClock
from vegrip.grip.compiled_rows import CompiledBatch, CompiledPackets, join
from vegrip.grip.frame_path import BatchPath
from vegrip.grip.node import GraspForce
from vegrip.grip.wires import COMMANDED, LEFT_ALONE, REPORT
from vegrip.messages import FingertipState, ForceCommand, SlipMargin
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID, BatchCodec
from vegrip.transport.open import Hand, open_endpoint
from vegrip.transport.zmq_endpoint import BatchEndpoint
from vegrip.trials.candidates import demo_parameters, make_node

STATE_ROW, COMMAND_ROW = 50, 26
Batch = tuple[int, bytes]


def batches_of(log: Log, seed: int = -1) -> list[Batch]:
    """Return the states of a log with their times, as batches; from a ``seed`` on, some rows are broken."""
    codec, out = log.codec(), BatchCodec(log.fingers)
    rng, found = np.random.default_rng(max(seed, 0)), []
    heard = [(event.now, codec.decode(event.frame)) for event in log.events if event.frame is not None]
    states = [(now, message) for now, message in heard if isinstance(message, FingertipState)]
    for _, group in groupby(states, lambda pair: pair[1].seq):
        pairs = list(group)
        rows = [row for _, state in pairs for row in out.encode(state)]
        data = out.pack(FingertipState, rows)
        if seed >= 0 and rng.random() < 0.3:
            data[int(rng.integers(FIRST_ROW, len(data)))] ^= 1 << int(rng.integers(8))
            out.seal(data, FingertipState, len(rows))
        found.append((pairs[-1][0], bytes(data)))
    return found


def node_for(log: Log, mode: str) -> GraspForce:
    node, codec = make_node(demo_parameters(), log.fingers), BatchCodec(log.fingers)
    node.configure()
    node.activate()
    lines = {finger: line for finger in log.fingers if (line := codec.line(finger)) is not None}
    node.run_compiled(lines, mode)
    return node


def answers_to_batches(log: Log, mode: str, given: list[Batch]) -> list[list[bytes]]:
    """Return the rows of commands to each batch, answered at once; what is left alone goes unanswered."""
    node, answers = node_for(log, mode), []
    for now, payload in given:
        answered = node.on_batch(payload, payload[13], now, now)
        assert answered is not None
        starts = range(FIRST_ROW, FIRST_ROW + answered[1] * COMMAND_ROW, COMMAND_ROW)
        answers.append([bytes(node.batch.commands[at : at + COMMAND_ROW]) for at in starts])
    return answers


def answers_to_rows(log: Log, mode: str, given: list[Batch]) -> list[list[bytes]]:
    """Return the same, answered row by row as frames are."""
    node, answers = node_for(log, mode), []
    fingers = {finger.numbers.on_wire.state_id: name for name, finger in node.compiled_fingers.items()}
    for now, payload in given:
        found = []
        for at in range(FIRST_ROW, len(payload), STATE_ROW):
            name = fingers.get(ROW_ID.unpack_from(payload, at)[0])
            frame = np.zeros(64, dtype=np.uint8)
            frame[:48] = np.frombuffer(payload, np.uint8, 48, at + 2)
            if name is not None and node.on_frame(name, frame, 48, now, now) & COMMANDED:
                head = ROW_ID.pack(node.compiled_fingers[name].numbers.on_wire.command_id)
                found.append(head + node.fingers[name].numbers.answer_frame.tobytes())
        answers.append(found)
    return answers


@pytest.mark.parametrize("seed", [-1, 0, 1])
def test_a_batch_is_answered_as_its_rows_one_by_one(hand_log: Log, mode: str, seed: int) -> None:
    given = batches_of(hand_log, seed)
    answers = answers_to_batches(hand_log, mode, given)
    assert answers == answers_to_rows(hand_log, mode, given)
    assert sum(map(len, answers)) > 1000


def test_plain_python_answers_as_what_runs_compiled(hand_log: Log, mode: str) -> None:
    given = batches_of(hand_log, 2)[:40]
    assert answers_to_batches(hand_log, "python", given) == answers_to_batches(hand_log, mode, given)


def test_fingers_are_answered_at_once_when_each_of_them_has_a_line(hand_log: Log, mode: str) -> None:
    node, codec = node_for(hand_log, mode), BatchCodec(hand_log.fingers)
    assert isinstance(node.batch, CompiledBatch)
    assert node.packets is None
    assert node.path_taken.endswith("), all fingers at once")
    line = codec.line("thumb")
    assert line is not None
    node.run_compiled({"thumb": line}, mode)
    assert (node.batch, node.packets, [*node.compiled_fingers]) == (None, None, ["thumb"])
    assert node.path_taken.endswith("), finger by finger")
    node.run_compiled({}, mode)
    assert (node.batch, node.packets, [*node.compiled_fingers]) == (None, None, [])


@pytest.mark.parametrize("refused", [(2,), (0,), (0, 1), (1, 3, 4)])
def test_a_row_that_is_refused_is_left_to_the_codec_and_the_others_are_answered(
    hand_log: Log, mode: str, refused: tuple[int, ...]
) -> None:
    node, given = node_for(hand_log, mode), batches_of(hand_log)
    for now, payload in given[:20]:
        node.on_batch(payload, payload[13], now, now)
    now, payload = given[20]
    broken = bytearray(payload)
    for row in refused:
        broken[FIRST_ROW + row * STATE_ROW + 20] ^= 1
    answered = node.on_batch(bytes(broken), payload[13], now, now)
    assert answered is not None
    assert [row for row in range(payload[13]) if answered[0][row] == LEFT_ALONE] == [*refused]
    assert answered[1] == len(hand_log.fingers) - len(refused)
    left = {node.batch.finger_of(payload, row).name for row in refused}
    assert {name for name, finger in node.fingers.items() if not finger.numbers.is_on_line} == left


def fingers_of(*state_ids: int, reports: tuple[int, ...] = (7, 8, 9), module: object = "one") -> Any:
    return [
        SimpleNamespace(
            name=f"f{i}",
            numbers=SimpleNamespace(
                module=module if module != "each" else [i],
                on_wire=SimpleNamespace(state_id=state_id, command_id=i, report_ids=reports),
            ),
        )
        for i, state_id in enumerate(state_ids)
    ]


@pytest.mark.parametrize(
    ("fingers", "kind"),
    [
        (fingers_of(2048, 4096), CompiledBatch),
        (fingers_of(2048), CompiledBatch),
        (fingers_of(2047, 0), CompiledPackets),
        (fingers_of(5), CompiledPackets),
        (fingers_of(2047, 2048), type(None)),
        (fingers_of(1, 2, reports=()), type(None)),
        (fingers_of(1, 2, module="each"), type(None)),
    ],
)
def test_fingers_of_one_step_are_joined_by_how_their_states_travel(fingers: Any, kind: type[Any]) -> None:
    """There is room for the commands of thirty rows, each with its identifier or the head of a request."""
    found = join(fingers, np.zeros(3))
    assert type(found) is kind
    if isinstance(found, CompiledBatch):
        assert len(found.commands) == FIRST_ROW + 30 * COMMAND_ROW
    elif found is not None:
        assert len(found.commands) == 30 * (14 + 24)


def test_a_row_is_of_the_finger_with_its_identifier_and_else_of_nobody() -> None:
    batch = CompiledBatch(fingers_of(2048, 4096, 6150), np.zeros(3))
    for known in ((6150, 2048, 4096), (2048, 2049, 6150, 4097), (6151, 4096), (4096 + 256, 6150, 6150)):
        payload = bytes(FIRST_ROW) + b"".join(ROW_ID.pack(one) + bytes(STATE_ROW - 2) for one in known)
        names = [{2048: "f0", 4096: "f1", 6150: "f2"}.get(one, "") for one in known]
        assert batch.names_in(payload, len(known)) == names
        found = [batch.finger_of(payload, row) for row in range(len(known))]
        assert ["" if one is None else one.name for one in found] == names


@pytest.mark.parametrize("done", sorted(set(permutations((LEFT_ALONE, LEFT_ALONE, COMMANDED, REPORT)))))
def test_the_rows_that_were_answered_are_counted_wherever_they_stand(done: tuple[int, ...]) -> None:
    names, counted, felt = ["a", "b", "c", "d"], [], []
    fingers = {
        name: SimpleNamespace(numbers=SimpleNamespace(felt=lambda force=3.0 + i: (force, 1.0)))
        for i, name in enumerate(names)
    }
    node: Any = SimpleNamespace(
        fingers=fingers,
        batch=SimpleNamespace(commands=bytearray(COMMAND_ROW), names_in=lambda *_: names),
        run_compiled=lambda _: None,
        on_batch=lambda *_: (bytearray(done), 0),
    )
    endpoint = SimpleNamespace(line=lambda _: SimpleNamespace(state_id=1, command_id=2))
    clock, statistics = (
        SimpleNamespace(now=lambda: 7),
        SimpleNamespace(batch=lambda *one: counted.append(one)),
    )
    senders = SimpleNamespace(note_values=lambda *one: felt.append(one))
    path = BatchPath(node, endpoint, (clock, statistics, senders, None, None))  # type: ignore[arg-type]
    path.prepare()
    assert path.answer_batch(b"", 4, 5) == (bytearray(done), [names[done.index(REPORT)]])
    assert path.frames == 2
    assert counted == [(2, 0, 5, 7)]
    assert felt == [("a", 3.0, 1.0)]


@pytest.mark.usefixtures("runtime")
def test_the_loop_answers_batches_and_reports_besides(hand_log: Log) -> None:
    """Over a socket within one process; the states are stamped anew, so that they are of now."""
    codec, seq = hand_log.codec(), 0
    heard = [codec.decode(event.frame) for event in hand_log.events if event.frame is not None]
    states = [state for state in heard if isinstance(state, FingertipState)]
    here = Hand(hand_log.fingers)
    grip = {"kind": "zmq", "batch": True, "publish": "ipc:grip", "subscribe": ("ipc:hand",)}
    hand = {"kind": "zmq", "batch": True, "publish": "ipc:hand", "subscribe": ("ipc:grip",)}
    with closing(open_endpoint(grip, here)) as ours, closing(open_endpoint(hand, here)) as theirs:
        assert isinstance(theirs, BatchEndpoint)
        node = make_node(replace(demo_parameters(), report_period=0.005), hand_log.fingers)
        runner = Runner(node, ours, WallClock(), LoopSettings(tick_period=0.01))
        runner.start()
        got: list[object] = []
        fingers = len(hand_log.fingers)
        deadline = time.monotonic() + 60.0
        while sum(isinstance(one, ForceCommand) for one in got) < 200 and time.monotonic() < deadline:
            for state in states[seq * fingers : (seq + 1) * fingers]:
                theirs.send(replace(state, stamp=time.monotonic_ns(), seq=seq))
            theirs.flush()
            seq = min(seq + 1, len(states) // fingers - 1)
            runner.step()
            got += theirs.receive(0.0)
        assert isinstance(runner.frame_path, BatchPath)
        assert runner.frame_path.frames >= 150
        assert runner.statistics.commands >= 200
        assert {one.finger for one in got if isinstance(one, ForceCommand)} == set(hand_log.fingers)
        assert any(isinstance(one, SlipMargin) for one in got)
        # the log runs faster than its own time: forces rise so steeply that at times none would do
        assert set(ours.batches.clipped) <= {"force_reserve"}
        assert set(ours.rejected) <= {"clipped"}


def test_reports_of_several_fingers_stand_in_a_batch_one_behind_the_other(hand_log: Log, mode: str) -> None:
    node, given = node_for(hand_log, mode), batches_of(hand_log)
    for now, payload in given[:60]:
        node.on_batch(payload, payload[13], now, now)
        list(node.reports(hand_log.fingers[0], now))  # the first report of a finger goes as messages
    later = given[59][0] + 10**9
    packed = node.batch.report(hand_log.fingers[::-1], later)
    assert packed == [hand_log.fingers[0]]
    for name in hand_log.fingers:
        list(node.reports(name, given[59][0]))
    packed = node.batch.report(hand_log.fingers[::-1], later + 10**9)
    assert packed == list(hand_log.fingers[::-1])
    contacts, margins = b"", b""
    for name in packed:
        numbers = node.fingers[name].numbers
        rows = [
            ROW_ID.pack(one) + frame.tobytes()
            for one, frame in zip(numbers.on_wire.report_ids, numbers.report_frames, strict=True)
        ]
        contacts, margins = contacts + rows[0] + rows[1], margins + rows[2]
    assert node.batch.contacts[FIRST_ROW:] == contacts
    assert node.batch.margins[FIRST_ROW:] == margins
