"""Laws of telemetry."""

from hypothesis import given
from hypothesis import strategies as st

from vegrip.messages import FingertipState
from vegrip.runtime.telemetry import Direction, Telemetry


class ListSink:
    wanted = True
    every = 1

    def __init__(self):
        self.counted = 0
        self.got = []
        self.directions = set()
        self.closed = False

    def count(self, *_):
        self.counted += 1

    tally = count

    def wants(self, *_):
        return self.every == 1

    def takes(self, message, _):
        return self.every == 1 or message.seq % self.every == 0

    def listen(self):
        pass

    def publish(self, messages):
        self.got += [message.seq for message, _ in messages]
        self.directions |= {direction for _, direction in messages}

    def close(self):
        self.closed = True


@given(st.lists(st.integers(1, 30), max_size=20))
def test_the_oldest_are_dropped_and_every_message_is_either_taken_or_counted(bursts):
    sink = ListSink()
    telemetry = Telemetry(sink, capacity=10)
    seq = 0
    for burst in bursts:
        for _ in range(burst):
            telemetry.offer(FingertipState(0, "thumb", seq), Direction.OUT)
            seq += 1
        telemetry.drain()
        assert sink.got[-1] == seq - 1, "the newest is kept"
        assert len(sink.got) + telemetry.dropped == seq
    assert sink.got == sorted(sink.got)


def test_without_a_reader_the_newest_are_kept():
    sink = ListSink()
    telemetry = Telemetry(sink, capacity=3)
    for seq in range(8):
        telemetry.offer(FingertipState(0, "thumb", seq), Direction.IN)
    assert telemetry.dropped == 5
    telemetry.close()
    assert sink.got == [5, 6, 7]
    assert sink.directions == {Direction.IN}
    assert sink.closed


def test_the_thread_delivers_everything_and_ends_with_close():
    sink = ListSink()
    telemetry = Telemetry(sink)
    telemetry.start()
    for seq in range(500):
        telemetry.offer(FingertipState(0, "thumb", seq), Direction.OUT)
    telemetry.close()
    assert sink.got == list(range(500))
    assert telemetry.dropped == 0


def test_what_nobody_wants_is_counted_and_neither_kept_nor_dropped():
    sink = ListSink()
    sink.wanted = False
    telemetry = Telemetry(sink, capacity=3)
    for seq in range(8):
        telemetry.offer(FingertipState(0, "thumb", seq), Direction.IN)
    telemetry.drain()
    assert (sink.counted, sink.got, telemetry.dropped) == (8, [], 0)


def test_what_the_sink_does_not_take_is_neither_queued_nor_dropped():
    sink = ListSink()
    sink.every = 3
    telemetry = Telemetry(sink, capacity=3)
    for seq in range(8):
        telemetry.offer(FingertipState(0, "thumb", seq), Direction.IN)
    assert telemetry.drain()
    assert not telemetry.drain()
    assert (sink.counted, sink.got, telemetry.dropped) == (8, [0, 3, 6], 0)


def test_what_travelled_unmade_is_a_message_among_the_others_where_it_is_wanted():
    sink = ListSink()
    telemetry = Telemetry(sink)
    for seq in range(6):
        if seq % 2:
            telemetry.offer(FingertipState(0, "thumb", seq), Direction.IN)
        elif telemetry.count(FingertipState, "thumb", Direction.IN):
            telemetry.show(FingertipState(0, "thumb", seq), Direction.IN)
    telemetry.drain()
    assert (sink.counted, sink.got) == (6, list(range(6)))


def test_what_is_not_wanted_need_not_be_shown():
    sink = ListSink()
    telemetry = Telemetry(sink)
    sink.every = 2
    assert not telemetry.count(FingertipState, "thumb", Direction.IN)
    sink.every, sink.wanted = 1, False
    assert not telemetry.count(FingertipState, "thumb", Direction.IN)
    assert sink.counted == 2
