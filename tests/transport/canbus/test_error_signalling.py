"""Durations of error frames against a bus simulated bit by bit, and against the published bounds."""

from dataclasses import dataclass, field

from hypothesis import given
from hypothesis import strategies as st

from vegrip.transport.canbus import frame_bits as text
from vegrip.transport.canbus.bus_records import Frame, Stream
from vegrip.transport.canbus.frame_time import (
    BitTiming,
    BusFrame,
    frame_bits,
    frame_duration,
    write_record,
)

# --- the reference: as slow and as plain as possible; the bus is dominant (0) when any node is


@dataclass
class Node:
    """A state machine that puts one bit on the bus and sees one."""

    is_passive: bool = False
    sends: list[int] = field(default_factory=list)  # empty: it receives
    finds: int = -1  # finds an error in this bit, whatever it is
    phase: str = "frame"
    count: int = 0
    run: int = 0
    last: int | None = None
    saw_dominant_after_flag: bool = False
    found_at: int = -1
    finished_at: int = -1
    time: int = 0
    sent: int = 1

    def output(self, time: int) -> int:
        if self.phase == "frame":
            return self.sends[time] if self.sends else 1
        if self.phase == "flag":
            return 1 if self.is_passive else 0
        return 1

    def see(self, time: int, bit: int, sent: int) -> None:
        self.time, self.sent = time, sent
        getattr(self, self.phase)(bit)

    def frame(self, bit: int) -> None:
        self.run = self.run + 1 if bit == self.last else 1
        self.last = bit
        if (self.sends and bit != self.sent) or self.run == 6 or self.time == self.finds:
            self.found_at = self.time
            self.phase, self.count, self.last = "flag", 0, None

    def flag(self, bit: int) -> None:
        """An active flag is six bits; a passive one is over after six equal bits on the bus."""
        self.count = self.count + 1 if not self.is_passive or bit == self.last else 1
        self.last = bit
        if self.count == 6:
            self.phase, self.count = "wait", 0

    def wait(self, bit: int) -> None:
        """Recessive bits until the bus is recessive: the first bit of the delimiter."""
        if self.count == 0 and bit == 0:
            self.saw_dominant_after_flag = True
        self.count += 1
        if bit == 1:
            self.phase, self.count = "delimiter", 1

    def delimiter(self, _bit: int) -> None:
        self.count += 1
        if self.count == 8 + 3:
            self.phase, self.finished_at = "idle", self.time + 1

    def idle(self, _bit: int) -> None:
        pass


def disturb(nodes: list[Node], inverted: int = -1) -> int:
    """Return when the sender is ready for the next frame, all nodes having seen one bit ``inverted``."""
    sender = next(node for node in nodes if node.sends)
    time = 0
    while sender.finished_at < 0:
        outputs = [node.output(time) for node in nodes]
        bus = min(outputs)
        for node, sent in zip(nodes, outputs, strict=True):
            node.see(time, 1 - bus if time == inverted else bus, sent)
        time += 1
    return sender.finished_at


# --- laws

ONE_MEGABIT = BitTiming(1_000_000)
US = 1000

frames = st.one_of(
    st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)),
    st.tuples(st.integers(0, 0x1FFFFFFF), st.binary(max_size=8), st.just(True)),
).map(lambda fields: BusFrame(*fields))
places = st.floats(0.0, 1.0, exclude_max=True)


def record(frame):
    made = Frame()
    write_record(frame, made)
    return made


def bit_stream(frame):
    stream = Stream()
    text.write_stream(stream, record(frame))
    return stream


def error_duration(stream, position, is_alone, is_passive, is_answered, timing=ONE_MEGABIT):
    rates = timing.bitrate, timing.data_bitrate
    return text.error_duration(stream, position, is_alone, is_passive, is_answered, *rates)


def position_in(stream, place):
    return stream.first + int(place * (stream.last + 1 - stream.first))


def on_the_bus(frame):
    """The bits from the start of the frame; what follows the CRC never comes to be sent."""
    stream = bit_stream(frame)
    return [*stream.bits[: stream.count], *[1] * 13]


@given(frames, places, st.integers(1, 4))
def test_an_error_all_nodes_see_lasts_as_long_as_bit_by_bit(frame, place, receivers):
    stream = bit_stream(frame)
    position = position_in(stream, place)
    nodes = [Node(sends=on_the_bus(frame)), *[Node() for _ in range(receivers)]]
    bits = disturb(nodes, position)
    took = error_duration(stream, position, False, False, True)
    assert took == bits * US
    assert nodes[0].found_at == position
    assert 17 <= bits - (position + 1) <= 23


@given(frames, places, st.integers(0, 3))
def test_an_error_one_receiver_sees_lasts_as_long_as_bit_by_bit(frame, place, others):
    stream = bit_stream(frame)
    position = position_in(stream, place)
    bad = Node(finds=position)
    nodes = [Node(sends=on_the_bus(frame)), bad, *[Node() for _ in range(others)]]
    bits = disturb(nodes)
    took = error_duration(stream, position, True, False, others > 0)
    assert took == bits * US
    assert bad.saw_dominant_after_flag, "the first to find an error pays 8 more"
    assert not any(node.saw_dominant_after_flag for node in nodes[2:])


@given(frames, places, st.integers(1, 3))
def test_the_passive_flag_of_a_sender_lasts_as_long_as_bit_by_bit(frame, place, receivers):
    stream = bit_stream(frame)
    position = position_in(stream, place)
    nodes = [Node(is_passive=True, sends=on_the_bus(frame)), *[Node() for _ in range(receivers)]]
    bits = disturb(nodes, position)
    took = error_duration(stream, position, False, True, True)
    assert took == bits * US
    assert bits - (position + 1) + text.SUSPENSION <= 31, "the bound of Bosch 1991"


@given(frames, places)
def test_an_error_that_nobody_answers_takes_17_bits(frame, place):
    stream = bit_stream(frame)
    position = position_in(stream, place)
    sender = Node(sends=on_the_bus(frame))
    bits = disturb([sender], position)
    assert bits == position + 1 + 17
    took = error_duration(stream, position, False, False, False)
    assert took == bits * US


@given(frames)
def test_a_frame_nobody_acknowledges_ends_17_bits_after_the_slot(frame):
    total = frame_duration(frame, ONE_MEGABIT) // US
    slot_ends = total - (1 + 7 + 3)
    assert text.unacknowledged_duration(record(frame), 1_000_000, 1_000_000) == (slot_ends + 17) * US


@given(frames)
def test_the_stream_has_the_bits_that_the_duration_counts(frame):
    """What is left after the CRC: 13 bits, and a stuff bit should it end with five equal ones."""
    rest = frame_bits(frame)[0] - bit_stream(frame).count
    assert 13 <= rest <= 14


fd_frames = st.tuples(
    st.integers(0, 0x7FF),
    st.sampled_from([0, 8, 48, 64]).flatmap(lambda size: st.binary(min_size=size, max_size=size)),
    st.booleans(),
).map(lambda fields: BusFrame(fields[0], fields[1], fd=True, has_bit_rate_switch=fields[2]))


@given(fd_frames, places)
def test_in_an_fd_frame_only_the_bits_at_the_data_rate_are_shorter(frame, place):
    timing = BitTiming(1_000_000, 5_000_000)
    stream = bit_stream(frame)
    position = position_in(stream, place)
    notice = text.notice_bits(stream, position, False, False, True)
    took = error_duration(stream, position, False, False, True, timing)
    fast = max(0, position + 1 - stream.slow)
    in_data = fast > 0
    nominal = position + 1 - fast + 6 + 8 + 3 + (0 if in_data else notice)
    assert took == nominal * 1000 + (fast + (notice if in_data else 0)) * 200
    if not frame.has_bit_rate_switch:
        assert fast == 0
