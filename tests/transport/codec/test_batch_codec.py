"""Batches: what goes in comes out, and a damaged one says nothing."""

import math
import struct

import numpy as np
import pytest

from vegrip.errors import ConfigError
from vegrip.messages import Channel, ContactEstimate, Estimate, FingertipState, ForceCommand, Reason
from vegrip.transport.codec.batch_codec import FIRST_ROW, MAX_BATCH_ROWS, BatchCodec
from vegrip.transport.codec.database import database
from vegrip.transport.codec.protection import P04

FINGERS = tuple(f"finger{number}" for number in range(20))
NOW = 7_000_000_000


def states(seq: int = 5) -> list[FingertipState]:
    return [FingertipState(NOW, f, seq, 1.5 + i, displacement=1e-3) for i, f in enumerate(FINGERS)]


def packed(codec: BatchCodec, messages: list[FingertipState]) -> bytes:
    return bytes(codec.pack(FingertipState, [frame for m in messages for frame in codec.encode(m)]))


def unpacked(codec: BatchCodec, payload: bytes) -> list[FingertipState]:
    rows = codec.rows_in(payload, FingertipState)
    found = [codec.decode(codec.frame(payload, FingertipState, row, NOW)) for row in range(rows)]
    return [message for message in found if isinstance(message, FingertipState)]


def test_all_fingers_come_out_as_they_went_in() -> None:
    got = unpacked(BatchCodec(FINGERS), packed(BatchCodec(FINGERS), states()))
    assert [(m.finger, m.seq, m.stamp) for m in got] == [(f, 5, NOW) for f in FINGERS]
    assert [m.normal_force for m in got] == [1.5 + i for i in range(len(FINGERS))]
    assert all(math.isnan(m.temperature) for m in got)


@pytest.mark.parametrize(("settings", "stamp"), [({}, NOW), ({"use_sender_time": False}, NOW + 5_000_000)])
def test_a_state_is_of_the_time_of_its_sender_unless_asked_otherwise(settings, stamp) -> None:  # type: ignore[no-untyped-def]
    codec, payload = BatchCodec(FINGERS, **settings), packed(BatchCodec(FINGERS), states())
    codec.rows_in(payload, FingertipState)
    message = codec.decode(codec.frame(payload, FingertipState, 0, NOW + 5_000_000))
    assert message is not None
    assert message.stamp == stamp


def test_commands_come_out_as_they_went_in() -> None:
    codec, other = BatchCodec(FINGERS), BatchCodec(FINGERS)
    sent = ForceCommand(NOW, "finger19", 3, 2.5, 0.125, Reason.RAISE, expires=NOW + 100_000_000)
    payload = bytes(codec.pack(ForceCommand, codec.encode(sent)))
    assert other.rows_in(payload, ForceCommand) == 1
    assert other.decode(other.frame(payload, ForceCommand, 0, NOW)) == sent


def test_contacts_come_out_as_they_went_in_from_two_rows_each() -> None:
    codec, other = BatchCodec(FINGERS), BatchCodec(FINGERS)
    known = Estimate(0.5, 0.25, True, 0.125)
    sent = [ContactEstimate(NOW, f, 3, True, Channel.FORCE, known, limit_radius=known) for f in FINGERS]
    payload = bytes(codec.pack(ContactEstimate, [frame for one in sent for frame in codec.encode(one)]))
    rows = other.rows_in(payload, ContactEstimate)
    assert rows == 2 * len(FINGERS)
    got = [other.decode(other.frame(payload, ContactEstimate, row, NOW)) for row in range(rows)]
    assert [one for one in got if one is not None] == sent
    assert other.lost == 0


def test_a_contact_of_which_a_row_is_damaged_is_not_told_and_the_others_are() -> None:
    codec, other = BatchCodec(FINGERS), BatchCodec(FINGERS)
    sent = [ContactEstimate(NOW, f, 3, friction_coefficient=Estimate(0.5, 0.1)) for f in FINGERS]
    data = codec.pack(ContactEstimate, [frame for one in sent for frame in codec.encode(one)])
    data[FIRST_ROW + 66 + 20] ^= 1  # in the second row
    codec.seal(data, ContactEstimate, 2 * len(FINGERS))
    rows = other.rows_in(bytes(data), ContactEstimate)
    got = [other.decode(other.frame(bytes(data), ContactEstimate, row, NOW)) for row in range(rows)]
    assert [one.finger for one in got if isinstance(one, ContactEstimate)] == list(FINGERS[1:])


def test_a_batch_of_reports_of_as_many_fingers_as_there_may_be_is_not_too_long() -> None:
    names = [str(number) for number in range(MAX_BATCH_ROWS)]
    codec, known = BatchCodec(names), Estimate(0.5, 0.1)
    sent = [ContactEstimate(NOW, name, 0, friction_coefficient=known) for name in names]
    payload = bytes(codec.pack(ContactEstimate, [frame for one in sent for frame in codec.encode(one)]))
    assert BatchCodec(names).rows_in(payload, ContactEstimate) == 2 * MAX_BATCH_ROWS


def test_a_row_has_the_number_of_its_finger_above_the_identifiers_of_a_bus() -> None:
    payload, message = (
        packed(BatchCodec(FINGERS), states()),
        database().get_message_by_name("FingertipStateFd"),
    )
    head = struct.unpack_from("<BBH", payload, 12)
    assert head == (1, len(FINGERS), 2 + message.length)
    found = [struct.unpack_from("<H", payload, 16 + row * head[2])[0] for row in range(len(FINGERS))]
    assert found == [message.frame_id + 0x800 * (1 + row) for row in range(len(FINGERS))]


def test_batches_count_up_in_16_bits() -> None:
    codec = BatchCodec(FINGERS)
    first, second = (int.from_bytes(packed(codec, states())[2:4], "big") for _ in range(2))
    assert (first, second) == (1, 2)
    data = bytearray(packed(codec, states()))
    for _ in range(0x10000):
        codec.seal(data, FingertipState, len(FINGERS))
    assert int.from_bytes(data[2:4], "big") == first + 2


def test_every_flipped_bit_is_noticed() -> None:
    codec, payload = BatchCodec(FINGERS), packed(BatchCodec(FINGERS), states())
    for bit in np.random.default_rng(0).choice(8 * len(payload), 300, replace=False).tolist():
        broken = bytearray(payload)
        broken[bit // 8] ^= 1 << bit % 8
        assert codec.rows_in(bytes(broken), FingertipState) == -1
    assert codec.rejected["checksum"] == 300


@pytest.mark.parametrize("cut", [0, 3, FIRST_ROW - 1, FIRST_ROW, FIRST_ROW + 49])
def test_a_cut_batch_is_refused(cut: int) -> None:
    codec = BatchCodec(FINGERS)
    assert codec.rows_in(packed(codec, states())[:cut], FingertipState) == -1
    assert codec.rejected.total() == 1


@pytest.mark.parametrize(("size", "why"), [(4096, "checksum"), (4097, "size")])
def test_a_batch_has_at_most_4096_bytes(size: int, why: str) -> None:
    codec = BatchCodec(FINGERS)
    assert codec.rows_in(bytes(size), FingertipState) == -1
    assert codec.rejected == {why: 1}


@pytest.mark.parametrize(("at", "why"), [(12, "version"), (13, "rows"), (14, "rows")])
def test_another_version_number_or_size_of_rows_is_named_even_though_the_checksum_holds(
    at: int, why: str
) -> None:
    codec, broken = BatchCodec(FINGERS), bytearray(packed(BatchCodec(FINGERS), states()))
    broken[at] += 1
    P04.protect(broken, codec._data_ids[FingertipState])
    assert codec.rows_in(bytes(broken), FingertipState) == -1
    assert codec.rejected == {why: 1}


@pytest.mark.parametrize("rows", [0, 1, len(FINGERS)])
def test_a_batch_has_as_many_rows_as_went_in_and_one_without_any_is_whole(rows: int) -> None:
    other = BatchCodec(FINGERS)
    assert other.rows_in(packed(BatchCodec(FINGERS), states()[:rows]), FingertipState) == rows
    assert not other.rejected


def test_a_batch_of_states_is_none_of_commands_and_none_of_another_hand() -> None:
    payload = packed(BatchCodec(FINGERS, "left"), states())
    assert BatchCodec(FINGERS, "left").rows_in(payload, FingertipState) == len(FINGERS)
    assert BatchCodec(FINGERS, "left").rows_in(payload, ForceCommand) == -1
    assert BatchCodec(FINGERS, "right").rows_in(payload, FingertipState) == -1


def test_a_repeated_batch_says_nothing_new() -> None:
    codec, payload = BatchCodec(FINGERS), packed(BatchCodec(FINGERS), states())
    assert len(unpacked(codec, payload)) == len(FINGERS)
    assert unpacked(codec, payload) == []
    assert codec.rejected["counter"] == len(FINGERS)
    assert len(unpacked(codec, packed(BatchCodec(FINGERS), states(7)))) == len(FINGERS)
    assert unpacked(codec, packed(BatchCodec(FINGERS), states(6))) == [], "nor does one that was overtaken"
    assert codec.rejected["counter"] == 2 * len(FINGERS)
    assert not codec.broken


def test_a_row_of_a_finger_that_is_not_there_is_counted() -> None:
    assert len(unpacked(codec := BatchCodec(FINGERS[:3]), packed(BatchCodec(FINGERS), states()))) == 3
    assert codec.rejected["finger"] == len(FINGERS) - 3


def test_more_fingers_than_identifiers_are_refused() -> None:
    BatchCodec([str(number) for number in range(MAX_BATCH_ROWS)])
    with pytest.raises(ConfigError, match="at most 30"):
        BatchCodec([str(number) for number in range(MAX_BATCH_ROWS + 1)])


def test_a_batch_is_of_at_most_thirty_fingers_of_different_names() -> None:
    names = [f"finger{number}" for number in range(MAX_BATCH_ROWS + 1)]
    BatchCodec(names[:MAX_BATCH_ROWS])
    for refused in (names, ["thumb", "thumb"], [*names[:3], names[0]]):
        with pytest.raises(ConfigError, match="must be at most 30 different names"):
            BatchCodec(refused)
