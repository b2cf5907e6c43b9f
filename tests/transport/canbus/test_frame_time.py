"""Frame durations against published bounds and against a bit stream built independently."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.transport.canbus import frame_bits as text
from vegrip.transport.canbus.bus_records import CRC15_OF_BYTE, RUN_AFTER, STUFFED, Frame
from vegrip.transport.canbus.frame_time import (
    FD_SIZES,
    BitTiming,
    BusFrame,
    fd_size,
    frame_bits,
    frame_duration,
    typical_duration,
    write_record,
)

identifiers = st.booleans().flatmap(
    lambda extended: st.tuples(st.integers(0, (1 << (29 if extended else 11)) - 1), st.just(extended))
)


@st.composite
def classic_frames(draw):
    identifier, extended = draw(identifiers)
    if draw(st.booleans()):
        return BusFrame(identifier, draw(st.binary(max_size=8)), extended=extended)
    return BusFrame(identifier, extended=extended, is_remote=True, length_code=draw(st.integers(0, 8)))


@st.composite
def fd_frames(draw):
    identifier, extended = draw(identifiers)
    size = draw(st.sampled_from(FD_SIZES))
    byte = draw(st.sampled_from([0x00, 0xFF, 0x0F, 0xF0, 0x78, None]))
    data = bytes([byte]) * size if byte is not None else draw(st.binary(min_size=size, max_size=size))
    return BusFrame(
        identifier,
        data,
        extended=extended,
        fd=True,
        has_bit_rate_switch=draw(st.booleans()),
        is_error_passive=draw(st.booleans()),
    )


# --- the reference: bit lists, as slow and as plain as possible


def number(value, width):
    return [(value >> i) & 1 for i in range(width - 1, -1, -1)]


def stuffed(bits, break_last=True):
    out, run = [], 0
    for i, bit in enumerate(bits):
        run = run + 1 if out and out[-1] == bit else 1
        out.append(bit)
        if run == 5 and (break_last or i + 1 < len(bits)):
            out.append(1 - bit)
            run = 1
    return out


def crc15(bits):
    """Remainder of the long division by x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1."""
    divisor = number(0b1100010110011001, 16)
    rest = list(bits) + [0] * 15
    for i in range(len(bits)):
        if rest[i]:
            for j, d in enumerate(divisor):
                rest[i + j] ^= d
    return rest[-15:]


def head(frame):
    if frame.extended:
        return [
            0,
            *number(frame.identifier >> 18, 11),
            1,
            1,
            *number(frame.identifier & 0x3FFFF, 18),
            int(frame.is_remote),
        ]
    return [0, *number(frame.identifier, 11), int(frame.is_remote)]


def payload(frame):
    return list(itertools.chain.from_iterable(number(byte, 8) for byte in frame.data))


def classic_length(frame):
    bits = [*head(frame), 0, 0, *number(frame.code, 4), *payload(frame)]  # IDE r0, or r1 r0
    return len(stuffed(bits + crc15(bits))) + 1 + 2 + 7 + 3


def fd_length(frame):
    """Return all bits of an ISO CAN FD frame, whatever their rate."""
    before = head(frame) + ([] if frame.extended else [0]) + [1, 0, int(frame.has_bit_rate_switch)]
    control = [int(frame.is_error_passive), *number(frame.code, 4)]
    crc_field = [1, 0] * 2 + [0, 1] * 8 + [1] if len(frame.data) <= 16 else [1, 0] * 2 + [0, 1] * 10 + [1]
    with_fixed = []
    for i, bit in enumerate(crc_field):
        if i % 4 == 0:
            with_fixed.append(None)
        with_fixed.append(bit)
    if len(crc_field) % 4 == 0:
        with_fixed.append(None)
    return len(stuffed(before + control + payload(frame), break_last=False)) + len(with_fixed) + 1 + 2 + 7 + 3


# --- laws


@given(classic_frames())
def test_classic_frames_have_exactly_the_bits_of_the_stream(frame):
    assert frame_bits(frame) == (classic_length(frame), 0)


@given(fd_frames())
def test_fd_frames_have_exactly_the_bits_of_the_stream(frame):
    assert sum(frame_bits(frame)) == fd_length(frame)


@given(classic_frames())
def test_classic_frames_keep_within_the_published_bound(frame):
    """Davis, Burns, Bril, Lukkien 2007: g + 8 n + 13 + floor((g + 8 n - 1) / 4), g = 34 or 54."""
    g, n = (54 if frame.extended else 34), len(frame.data)
    nominal, _ = frame_bits(frame)
    assert g + 8 * n + 13 <= nominal <= g + 8 * n + 13 + (g + 8 * n - 1) // 4


@given(fd_frames())
def test_fd_frames_keep_within_the_published_bound(frame):
    """Bordoloi, Samii 2014, for 11-bit identifiers: 32 bits at the nominal rate and
    28 + 5 ceil((p - 16) / 64) + 10 p at the data rate. The ISO frame has 5 more (stuff count and its fixed
    stuff bit), and they leave out the stuff bit that may fall where the rate changes."""
    if frame.extended:
        return
    nominal, fast = frame_bits(frame)
    p = len(frame.data)
    assert 29 <= nominal <= 32
    assert fast <= 33 + (5 if p > 16 else 0) + 10 * p + 1


@pytest.mark.parametrize(("size", "bits"), [(0, 55), (8, 135)])
def test_the_worst_classic_frame_is_as_long_as_published(size, bits):
    g = 34
    assert g + 8 * size + 13 + (g + 8 * size - 1) // 4 == bits


def test_crc_of_the_catalogue():
    """Check value of CRC-15/CAN in the catalogue of parametrised CRC algorithms: 0x059E for "123456789"."""
    assert text.crc15_bits(0, int.from_bytes(b"123456789", "big"), 72) == 0x059E


@given(st.integers(0, 9), st.integers(0, 255))
def test_byte_tables_count_as_bit_by_bit(run, byte):
    assert (STUFFED[256 * run + byte], RUN_AFTER[256 * run + byte]) == text.stuff_bits(run, byte, 8)
    assert CRC15_OF_BYTE[byte] == text.crc15_bits(0, byte, 8)


def test_bit_rate_switch_shortens_a_frame_only_in_its_data_phase():
    timing = BitTiming(bitrate=500_000, data_bitrate=2_000_000)
    slow = BusFrame(0x555, bytes(range(64)), fd=True)
    fast = BusFrame(0x555, bytes(range(64)), fd=True, has_bit_rate_switch=True)
    nominal, data = frame_bits(fast)
    assert frame_duration(fast, timing) == nominal * 2000 + data * 500
    assert frame_duration(slow, timing) == sum(frame_bits(slow)) * 2000


@given(classic_frames(), classic_frames())
def test_the_arbitration_key_orders_frames_as_their_bits_do(one, other):
    """The first bit in which two arbitration fields differ decides; dominant (0) wins."""

    def key(frame):
        record = Frame()
        write_record(frame, record)
        return text.arbitration_key(record)

    def field(frame):
        return head(frame)[1:] + ([] if frame.extended else [0])  # IDE follows RTR of a standard frame

    first, second = field(one), field(other)
    differing = [(a, b) for a, b in zip(first, second, strict=False) if a != b]
    if differing:
        assert (key(one) < key(other)) == (differing[0] == (0, 1))


def test_a_typical_frame_lies_between_the_shortest_and_the_longest():
    timing = BitTiming()
    assert 111_000 < typical_duration(8, False, timing) < 135_000


@pytest.mark.parametrize(("length", "carried"), [(9, 12), (33, 48), (63, 64), (65, 64)])
def test_a_length_that_no_frame_has_takes_as_long_as_the_next_one(length, carried):
    timing = BitTiming()
    assert typical_duration(length, True, timing) == typical_duration(carried, True, timing)


def test_a_frame_holds_what_it_carries_and_the_next_smaller_one_does_not():
    for length in range(65):
        size = fd_size(length)
        assert size in FD_SIZES
        assert size >= length
        assert all(other < length or other >= size for other in FD_SIZES)
    assert fd_size(65) == 64
