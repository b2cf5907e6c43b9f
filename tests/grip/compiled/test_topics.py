"""States on single topics are answered compiled as the messages answer them, to the last byte."""

import math
import os
import time
from contextlib import closing
from dataclasses import replace

import msgpack
import numpy as np
import pytest

from validation.compiled_finger import Answers, Log, bits_left, differences, record
from validation.compiled_topics import TopicReplay, hostile_topics, on_topics
from validation.faults.table import CASES, Case
from vegrip.c99 import host
from vegrip.clock import WallClock
from vegrip.estimator.memory import CHANNELS
from vegrip.messages import FingertipState, ForceCommand, Reason, SlipMargin
from vegrip.model.native import kernel_mode
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.runtime.topic_path import TopicPath
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER
from vegrip.transport.codec.topics import data_id_of
from vegrip.transport.open import Hand, open_endpoint
from vegrip.trials.candidates import demo_parameters, make_node

LONG = bool(os.environ.get("VEGRIP_LONG"))
SHORT_CASES = ("normal force stuck at 2 N", "all states of one finger lost for 1 s")
FAULTS = [case for case in CASES if (LONG and not case.slow) or case.name in SHORT_CASES]


@pytest.fixture(scope="module")
def topic_log(hand_log: Log) -> Log:
    return on_topics(hand_log)


@pytest.fixture(scope="module")
def by_messages(topic_log: Log) -> Answers:
    return TopicReplay(topic_log).run()


def test_every_command_of_a_recorded_grasp_is_equal(topic_log: Log, by_messages: Answers, mode: str) -> None:
    compiled = TopicReplay(topic_log, mode).run()
    assert differences(by_messages, compiled) == []
    assert len(compiled.commands) > 1000
    assert compiled.compiled_frames == topic_log.frames


@pytest.mark.parametrize("case", FAULTS, ids=[case.name for case in FAULTS])
def test_every_command_under_a_fault_is_equal(case: Case, mode: str) -> None:
    log = on_topics(record(case, 0.0))
    assert differences(TopicReplay(log).run(), TopicReplay(log, mode).run()) == []


@pytest.mark.parametrize("seed", range(40 if LONG else 4))
def test_every_command_to_hostile_payloads_is_equal(topic_log: Log, seed: int, mode: str) -> None:
    log = replace(hostile_topics(topic_log, seed), sender_time=seed % 2 == 0)
    messages, compiled = TopicReplay(log).run(), TopicReplay(log, mode).run()
    assert differences(messages, compiled) == []
    assert sum(messages.rejected.values()) > 50, "the payloads were not hostile"
    assert compiled.compiled_frames > 0.5 * log.frames


def test_hostile_payloads_are_refused_for_every_reason(topic_log: Log) -> None:
    seen: set[str] = set()
    for seed in range(6):
        seen |= set(TopicReplay(hostile_topics(topic_log, seed)).run().rejected)
    assert seen == {"size", "checksum", "schema", "version", "type", "value", "finger", "counter"}


def test_going_to_and_fro_between_both_ways_changes_nothing(
    topic_log: Log, by_messages: Answers, mode: str
) -> None:
    rng = np.random.default_rng(7)
    replay = TopicReplay(topic_log, mode)
    for event in topic_log.events:
        if rng.random() < 0.2:
            replay.node.leave_lines(str(rng.choice(topic_log.fingers)))
        replay.meet(event)
    assert differences(by_messages, replay.finish()) == []


@pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("seed", [-1, 2])
def test_c_and_plain_python_leave_the_same_bits_in_the_whole_memory(topic_log: Log, seed: int) -> None:
    log = topic_log if seed < 0 else hostile_topics(topic_log, seed)
    log = replace(log, events=log.events[:600])
    assert bits_left(TopicReplay(log, "c")) == bits_left(TopicReplay(log, "python"))


@pytest.mark.skipif(kernel_mode() != "numba", reason="numba compiles for a minute; make test-numba")
def test_numba_leaves_the_bits_of_plain_python(topic_log: Log) -> None:
    log = hostile_topics(topic_log, 2)
    log = replace(log, events=log.events[:600])
    assert bits_left(TopicReplay(log, "numba")) == bits_left(TopicReplay(log, "python"))


def test_the_values_of_a_state_stand_in_one_order_everywhere() -> None:
    line = MsgpackCodec("", ("thumb",)).line("thumb")
    assert line is not None
    assert line._channels == CHANNELS


@pytest.mark.parametrize("seq", [0, 127, 70_000, 2**32 + 3])
@pytest.mark.parametrize("force", [0.0, -0.0, 3.3, 1e-300, 5.0])
def test_a_command_is_packed_to_the_bytes_of_the_codec(seq: int, force: float) -> None:
    codec = MsgpackCodec("left", ("thumb",))
    line = codec.line("thumb")
    assert line is not None
    command = ForceCommand(123_456_789_012, "thumb", seq, force, -0.25, Reason.SLIP, 123_556_789_012)
    packed = line.pack(seq, command.stamp, force, -0.25, int(Reason.SLIP), command.expires)
    assert codec.encode(command) == (line.command_topic.decode(), bytes(packed))


@pytest.mark.parametrize("use_sender_time", [True, False])
@pytest.mark.parametrize("stamp", [-(2**63), 2**63 - 1, 2**62, -(2**62)])
def test_a_stamp_out_of_all_time_is_left_to_messages(
    topic_log: Log, stamp: int, use_sender_time: bool, mode: str
) -> None:
    events = list(topic_log.events)
    numbers = [i for i, event in enumerate(events) if event.payload and event.finger == "index"]
    for place in numbers[40:43]:
        events[place] = replace(events[place], payload=stamped(events[place].payload, stamp))
    log = replace(topic_log, events=events, sender_time=use_sender_time)
    messages, compiled = TopicReplay(log).run(), TopicReplay(log, mode).run()
    assert differences(messages, compiled) == []
    assert compiled.compiled_frames > 0.5 * log.frames


def stamped(payload: bytes, stamp: int) -> bytes:
    body = msgpack.unpackb(payload[P04_HEADER:])
    data = bytearray(P04_HEADER) + msgpack.packb({**body, "stamp": stamp})
    data[P04_COUNTER] = (body["seq"] & 0xFFFF).to_bytes(2, "big")
    P04.protect(data, data_id_of(f"/hand/{body['finger']}/state"))
    return bytes(data)


@pytest.mark.usefixtures("runtime")
def test_the_loop_answers_topics_and_reports_besides(hand_log: Log) -> None:
    """Over a socket within one process; the states are stamped anew, so that they are of now."""
    codec, seq = hand_log.codec(), 0
    heard = [codec.decode(event.frame) for event in hand_log.events if event.frame is not None]
    states = [state for state in heard if isinstance(state, FingertipState)]
    here = Hand(hand_log.fingers)
    grip = {"kind": "zmq", "publish": "ipc:grip", "subscribe": ("ipc:hand",)}
    hand = {"kind": "zmq", "publish": "ipc:hand", "subscribe": ("ipc:grip",)}
    with closing(open_endpoint(grip, here)) as ours, closing(open_endpoint(hand, here)) as theirs:
        node = make_node(replace(demo_parameters(), report_period=0.005), hand_log.fingers)
        runner = Runner(node, ours, WallClock(), LoopSettings(tick_period=0.01))
        runner.start()
        assert runner.path_taken.startswith("states are answered by the compiled step (")
        got: list[object] = []
        fingers = len(hand_log.fingers)
        deadline = time.monotonic() + 60.0
        while sum(isinstance(one, ForceCommand) for one in got) < 200 and time.monotonic() < deadline:
            for state in states[seq * fingers : (seq + 1) * fingers]:
                theirs.send(replace(state, stamp=time.monotonic_ns(), seq=seq))
            seq = min(seq + 1, len(states) // fingers - 1)
            runner.step()
            got += theirs.receive(0.0)
        assert isinstance(runner.hot_path, TopicPath)
        assert runner.hot_path.frames >= 150
        commands = [one for one in got if isinstance(one, ForceCommand)]
        assert len(commands) >= 200
        assert {one.finger for one in commands} == set(hand_log.fingers)
        assert all(math.isfinite(one.normal_force) and one.expires > one.stamp for one in commands)
        assert any(isinstance(one, SlipMargin) for one in got)
        # the log runs faster than its own time: forces rise so steeply that at times none would do
        assert set(ours.rejected) <= {"clipped"}
        assert not theirs.rejected
