"""Laws of the telemetry socket: one that misbehaves takes nothing from the others."""

import itertools
import math
import time
from collections import Counter

import pytest
import zmq

from vegrip.messages import FingertipState, Lifecycle, NodeStatus
from vegrip.runtime import telemetry_socket
from vegrip.runtime.registry import Entry
from vegrip.runtime.telemetry import Direction
from vegrip.runtime.telemetry_socket import (
    MOST_PREFIXES,
    MOST_STREAMS,
    NEWEST,
    TelemetryReader,
    TelemetrySocket,
)
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

PATIENCE = 20.0  # [s] on a busy machine
SENT = range(1000, 2000)  # [ns] stamps of states


@pytest.fixture
def entry(runtime):
    return Entry("/grip", "echo")


@pytest.fixture
def counts():
    return Counter()


@pytest.fixture
def sink(entry, counts):
    opened = TelemetrySocket(entry.telemetry, MsgpackCodec(), ("thumb",), counts)
    yield opened
    opened.close()


@pytest.fixture
def reader(entry):
    opened = TelemetryReader([entry])
    yield opened
    opened.close()


@pytest.fixture
def stranger(entry):
    with zmq.Context() as context, context.socket(zmq.XSUB) as socket:
        socket.linger = 0
        socket.connect(entry.telemetry)
        yield socket


def until(condition):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.005)
    return False


def test_a_node_that_sends_faster_than_it_is_read_neither_silences_another_nor_holds_the_reader(
    entry, sink, counts, monkeypatch
):
    other = Entry("/hand", "echo")
    quiet = TelemetrySocket(other.telemetry, MsgpackCodec(), ("thumb",), counts)
    reader = TelemetryReader([entry, other])
    try:
        for one in (sink, quiet):
            assert is_received(one, reader)
        while list(reader.read(0.01)):
            pass
        states = [(FingertipState(stamp, "thumb", stamp, normal_force=0.5), Direction.IN) for stamp in SENT]
        for one in (sink, quiet):
            one.publish(states)
        assert until(lambda: len(reader._poller.poll(0)) == 2)
        spent = itertools.count()  # every look at the clock is 1 s later
        monkeypatch.setattr(telemetry_socket.time, "monotonic", lambda: float(next(spent)))
        heard = [(node.name, message.stamp) for node, _, _, message in reader.read(0.5)]
        monkeypatch.undo()
        assert {name for name, _ in heard} == {"/grip", "/hand"}
        assert len(heard) < len(SENT)
        while more := [(node.name, message.stamp) for node, _, _, message in reader.read(0.2)]:
            heard += more
        for name in ("/grip", "/hand"):
            assert [stamp for node, stamp in heard if node == name] == list(SENT)
    finally:
        reader.close()
        quiet.close()


def is_received(sink, reader):
    """Whether what is published arrives at ``reader``."""
    sent = FingertipState(1, "thumb", is_received.seq, normal_force=0.5)
    is_received.seq += 1

    def heard():
        sink.listen()
        sink.publish([(sent, Direction.IN)])
        return any(message == sent for *_, message in reader.read(0.01))

    return until(heard)


is_received.seq = 0

RUDE = {
    "an empty message": [[b""]],
    "an end of what it had not begun": [[b"\x00"]],
    "the same of a topic": [[b"\x00/hand/thumb/state"], [b"\x00/hand"]],
    "begun and ended": [[b"\x01"], [b"\x00"], [b"\x00"]],
    "begun twice and ended": [[b"\x01"], [b"\x01"], [b"\x00"]],
    "text": [[b"hello"]],
    "two frames": [[b"\x02", b"\x00"]],
    "many": [[b"\x00"]] * 200,
}


@pytest.mark.parametrize("messages", RUDE.values(), ids=RUDE)
def test_nothing_that_one_sends_ends_the_subscription_of_another(sink, reader, stranger, counts, messages):
    assert is_received(sink, reader)
    for message in messages:
        stranger.send_multipart(message)
    stranger.send(b"\x01/end")

    def arrived():
        sink.listen()
        return b"/end" in sink._subscribed

    assert until(arrived)
    assert is_received(sink, reader)
    odd = [message for message in messages if message[0][:1] not in (b"\x00", b"\x01")]
    assert counts["subscription"] >= len(odd) > 0 or not odd


def test_when_the_last_has_gone_nothing_is_wanted_any_more(sink, entry):
    for _ in range(3):
        readers = [TelemetryReader([entry]) for _ in range(2)]
        assert all(is_received(sink, reader) for reader in readers)
        readers[0].close()
        assert is_received(sink, readers[1])
        readers[1].close()
        assert until(lambda: sink.listen() or not sink.wanted)


def test_prefixes_without_end_are_one_that_is_everything(sink, reader, stranger):
    for number in range(2 * MOST_PREFIXES):
        stranger.send(b"\x01/x%d" % number)
    assert until(lambda: sink.listen() or b"" in sink._subscribed)
    assert len(sink._subscribed) <= MOST_PREFIXES + 1
    assert is_received(sink, reader)


def test_made_up_names_take_no_place_of_a_configured_finger_in_the_counts(sink):
    for number in range(2 * MOST_STREAMS):
        sink.count(NodeStatus(0, f"n{number}", 0, Lifecycle.ACTIVE), Direction.IN)
    sink.count(FingertipState(0, "thumb", 0), Direction.IN)
    sink.count(FingertipState(0, "other", 0), Direction.IN)
    topics = sink.topics()
    assert topics["/hand/thumb/state"] == {"in": 1, "out": 0}
    assert "/hand/other/state" not in topics


def heard_after(sink, reader, states):
    """Publish ``states`` once the subscription has arrived, and return the forces that ``reader`` hears."""
    assert until(lambda: sink.listen() or sink.wanted)
    sink._newest_due = math.inf  # it is not due before all are published, however long that takes
    sink.publish([(state, Direction.IN) for state in states])
    sink._newest_due = 0.0
    heard = []

    def collect():
        sink.listen()
        heard.extend(message.normal_force for _, _, _, message in reader.read(0.01))
        return states[-1].normal_force in heard

    assert until(collect)
    return heard


STATES = [FingertipState(i + 1, "thumb", i, normal_force=float(i)) for i in range(50)]


def test_of_a_topic_behind_newest_only_the_newest_message_is_sent(sink, entry):
    reader = TelemetryReader([entry], [f"{NEWEST}/hand/thumb/state"])
    assert heard_after(sink, reader, STATES) == [49.0]
    reader.close()


@pytest.mark.parametrize("prefix", ["", "/hand/thumb/state"])
def test_every_message_comes_once_to_those_who_want_every_one_whatever_others_want(
    sink, entry, stranger, prefix
):
    stranger.send(b"\x01newest:/hand/thumb/state")
    reader = TelemetryReader([entry], [prefix])
    assert until(lambda: sink.listen() or len(sink._subscribed) == 2)
    assert heard_after(sink, reader, STATES) == [float(i) for i in range(50)]
    sink._newest_due = 0.0
    sink.listen()  # sends the newest to the others
    assert not list(reader.read(0.1))
    reader.close()


def test_the_newest_of_a_stream_that_ends_is_sent_all_the_same(sink, entry, monkeypatch):
    monkeypatch.setattr(telemetry_socket, "NEWEST_PERIOD", 0.05)
    reader = TelemetryReader([entry], [f"{NEWEST}/hand/"])
    assert heard_after(sink, reader, STATES[:1]) == [0.0]
    assert heard_after(sink, reader, STATES[1:2]) == [1.0]  # within the period: sent by a later look
    reader.close()


def test_of_a_stream_whose_newest_suffices_nothing_is_queued_and_the_newest_is_sent(sink, entry):
    reader = TelemetryReader([entry], [f"{NEWEST}/hand/thumb/state"])
    assert heard_after(sink, reader, STATES[:1]) == [0.0]  # from now on it is known who wants what
    assert [sink.takes(state, Direction.IN) for state in STATES[1:]] == [False] * 49
    sink._newest_due = 0.0
    sink.listen()
    assert until(lambda: [m.normal_force for _, _, _, m in reader.read(0.1)] == [49.0])
    assert sink.takes(FingertipState(1, "ring", 0), Direction.IN)  # of which it is not known yet
    reader.close()


def test_of_a_stream_whose_newest_suffices_one_is_wanted_in_a_period_and_newer_ones_at_its_end(sink, entry):
    reader = TelemetryReader([entry], [f"{NEWEST}/hand/thumb/state"])
    assert heard_after(sink, reader, STATES[:1]) == [0.0]  # from now on it is known who wants what
    thumb = FingertipState, "thumb", Direction.IN
    sink._newest_due = math.inf
    assert sink.wants(*thumb)
    assert not sink.takes(FingertipState(5, "thumb", 5, 5.0), Direction.IN)
    assert not sink.wants(*thumb), "there is one"
    sink._newest_due = 0.0
    assert sink.wants(*thumb), "the period ends"
    assert not sink.takes(FingertipState(6, "thumb", 6, 6.0), Direction.IN)
    sink.listen()
    assert until(lambda: [m.normal_force for _, _, _, m in reader.read(0.1)] == [6.0])
    reader.close()


def test_a_stream_without_a_subscriber_is_not_wanted(sink, entry):
    reader = TelemetryReader([entry], ["/hand/thumb/state"])
    assert heard_after(sink, reader, STATES) == [float(i) for i in range(50)]
    assert sink.wants(FingertipState, "thumb", Direction.IN)
    assert sink.wants(FingertipState, "ring", Direction.IN), "it is not known yet who wants it"
    sink.publish([(FingertipState(1, "ring", 0), Direction.IN)])
    assert not sink.wants(FingertipState, "ring", Direction.IN)
    reader.close()
