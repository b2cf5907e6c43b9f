"""What a compiled finger knows of frames and topics is what the codecs of messages know."""

import math

import pytest

from vegrip.estimator.memory import CHANNELS
from vegrip.messages import FingertipState
from vegrip.transport.codec.database import database, layouts
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.codec.part_text import _meaning

PARTS = [
    part
    for layout in layouts().layouts
    if layout.schema.cls is FingertipState and not layout.fd
    for part in layout.parts
]


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_a_raw_value_means_something_where_the_converter_reads_one(part) -> None:
    names = {
        "signed_byte": lambda raw: (raw ^ 128) - 128,
        "signed_half_word": lambda raw: (raw ^ 32768) - 32768,
    }
    for slot in part.slots:
        signal = database().get_message_by_name(part.name).get_signal_by_name(slot.name)
        condition = compile(_meaning(part, slot.name) or "True", "", "eval")
        at, data = signal.start // 8, bytearray(8)
        for raw in range(1 << signal.length):
            data[at : at + signal.length // 8] = raw.to_bytes(signal.length // 8, "little")
            half = 1 << signal.length - 1
            value = (raw ^ half) - half if signal.is_signed else raw
            assert eval(condition, names | {"data": data}) == (slot.convert.read(value) is not None)  # noqa: S307


def test_some_raw_values_mean_nothing() -> None:
    assert any(_meaning(part, slot.name) for part in PARTS for slot in part.slots)


@pytest.mark.parametrize("seq", [0, 1, 0xFFFF, 0x10000, 2**32 - 1])
def test_a_state_of_any_counter_is_unpacked_from_its_topic(seq: int) -> None:
    state = FingertipState(5_000, "thumb", seq, 1.5, displacement=1e-3, temperature=math.nan)
    topic, payload = MsgpackCodec("", ("thumb",)).encode(state)
    line = MsgpackCodec("", ("thumb",)).line("thumb")
    assert topic.encode() == line.state_topic
    values = bytearray(8 * len(CHANNELS))
    assert line.unpack(bytes(payload), 6_000, values) == (seq, 5_000)
    assert memoryview(values).cast("d")[0] == 1.5
