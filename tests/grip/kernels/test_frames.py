"""Bytes, checksums, counters and times of a frame, against slow and plain ways to have the same."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.transport.codec.sequence import Sequence

data_of = st.binary(min_size=6, max_size=64)


def crc_bit_by_bit(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


@given(data=data_of, data_id=st.integers(0, 0xFFFF))
def test_the_checksum_is_that_of_bits_over_what_follows_it_and_the_data_id(kernels, data, data_id) -> None:
    frame = np.frombuffer(data, np.uint8).copy()
    expected = crc_bit_by_bit(data[2:] + struct.pack("<H", data_id))
    assert kernels.crc_of(frame, len(frame), data_id) == expected
    kernels.protect(frame, len(frame), data_id)
    assert frame.tobytes() == struct.pack("<H", expected) + data[2:]
    assert kernels.is_intact(frame, len(frame), data_id)
    frame[-1] ^= 16
    assert not kernels.is_intact(frame, len(frame), data_id)


@given(bits=st.integers(0, 2**32 - 1), at=st.integers(0, 4))
def test_words_stand_with_the_least_byte_first(kernels, bits, at) -> None:
    data = np.zeros(9, np.uint8)
    kernels.put_word(data, at, bits)
    assert data.tobytes() == bytes(at) + struct.pack("<I", bits) + bytes(5 - at)
    assert kernels.word(data, at) == bits
    half = np.zeros(9, np.uint8)
    kernels.put_half_word(half, at, bits & 0xFFFF)
    assert half.tobytes() == bytes(at) + struct.pack("<H", bits & 0xFFFF) + bytes(7 - at)
    assert kernels.half_word(half, at) == bits & 0xFFFF


@given(value=st.floats(width=32, allow_nan=False))
def test_numbers_are_singles(kernels, value) -> None:
    (bits,) = struct.unpack("<I", struct.pack("<f", value))
    assert kernels.bits_of_real(value) == bits
    assert kernels.real_of_bits(bits) == value


SILENCE = 500_000_000  # [ns]
steps = st.one_of(st.integers(-3, 3), st.sampled_from([9_999, 10_000, 10_001, 2**31, 2**32 - 1]))
waits = st.sampled_from([2_000_000, SILENCE, SILENCE + 1])


@given(first=st.integers(0, 2**32 - 1), moves=st.lists(st.tuples(steps, waits), max_size=12))
def test_counters_go_on_as_those_of_the_codec(kernels, first, moves) -> None:
    t, theirs = np.zeros(200, np.int64), Sequence(2**32)
    t[kernels.LINE_LAST] = -1
    counter, arrival = first, 10**9
    assert theirs.advance(counter, arrival) == first
    kernels.count_on(t, counter, arrival)
    for step, wait in moves:
        counter, arrival = (counter + step) & 0xFFFFFFFF, arrival + wait
        number = theirs.advance(counter, arrival)
        assert kernels.is_next(t, counter, arrival) == (number is not None)
        if number is None:
            counter = (counter - step) & 0xFFFFFFFF
            continue
        kernels.count_on(t, counter, arrival)
        assert (t[kernels.LINE_LAST], t[kernels.LINE_STAMP], t[kernels.LINE_LOST]) == (
            number,
            arrival,
            theirs.lost,
        )


@pytest.mark.parametrize("off", [-(2**31) + 1, -1000, 0, 1000, 2**31 - 1])
@pytest.mark.parametrize("arrival", [5 * 2**32 * 1000, 5 * 2**32 * 1000 + 777_000, (2**33 - 1) * 1000])
def test_a_time_of_the_sender_is_the_one_nearest_to_the_arrival(
    kernels, t, monkeypatch, off, arrival
) -> None:
    told = (arrival // 1000 + off) & 0xFFFFFFFF
    monkeypatch.setattr(kernels, "time_of_state", lambda _: told)
    t[kernels.SETUP_SENDER_TIME] = 0
    assert kernels.stamp_of(t, b"", arrival) == arrival
    t[kernels.SETUP_SENDER_TIME] = 1
    assert kernels.stamp_of(t, b"", arrival) == arrival // 1000 * 1000 + off * 1000


@pytest.mark.parametrize("broken", ["", "length", "checksum", "version", "values", "counter"])
def test_a_frame_is_welcome_when_all_of_it_is_well(kernels, t, monkeypatch, broken) -> None:
    frame = np.arange(kernels.STATE_LENGTH, dtype=np.uint8)
    t[kernels.SETUP_STATE_ID] = 0x123
    kernels.protect(frame, len(frame), 0x123)
    version = kernels.WIRE_VERSION + (broken == "version")
    monkeypatch.setattr(kernels, "version_of_state", lambda _: version)
    monkeypatch.setattr(kernels, "values_mean_something", lambda _: broken != "values")
    monkeypatch.setattr(kernels, "counter_of_state", lambda _: 7 if broken == "counter" else 8)
    t[kernels.LINE_LAST], t[kernels.LINE_STAMP] = 7, 10**9
    frame[9] ^= broken == "checksum"
    length = len(frame) - (broken == "length")
    assert kernels.is_welcome(t, frame, length, 10**9 + 1) == (broken == "")
    t[kernels.LINE_LAST] = -1  # the first may have any counter
    assert kernels.is_welcome(t, frame, length, 10**9 + 1) == (broken in ("", "counter"))
