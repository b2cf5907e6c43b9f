"""Nothing that comes from the wire raises, and nothing without a valid checksum is a message."""

import msgpack
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.database import layouts
from vegrip.transport.codec.protection import P04, P04_HEADER
from vegrip.transport.codec.schema import Topics, message_set

FINGERS = ("thumb", "index", "middle", "ring", "little")
PARTS = [part for layout in layouts().layouts for part in layout.parts]
TOPICS = [schema.topic.replace("{finger}", "thumb") for schema in message_set().messages.values()]
KEYS = sorted({field.name for schema in message_set().messages.values() for field in schema.fields})

scalars = st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text() | st.binary()
objects = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(), inner, max_size=6)
)
bodies = st.dictionaries(st.sampled_from(KEYS), objects).map(lambda body: {"version": 1} | body) | objects


@pytest.mark.parametrize("fd", [False, True])
@given(st.integers(), st.binary(max_size=70), st.booleans(), st.integers())
@example(0x100, b"", False, 0)
def test_random_frames_never_raise_and_are_no_messages(
    fd: bool, identifier: int, data: bytes, frame_fd: bool, stamp: int
) -> None:
    codec = CanCodec(FINGERS, fd=fd)
    assert codec.decode(Frame(identifier, data, frame_fd, stamp)) is None
    assert sum(codec.rejected.values()) + codec.foreign == 1


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
@given(data=st.data())
def test_any_content_with_a_valid_checksum_is_a_message_or_a_named_refusal(
    part: object, data: st.DataObject
) -> None:
    chosen = next(p for p in PARTS if p is part)
    payload = bytearray(data.draw(st.binary(min_size=chosen.length, max_size=chosen.length)))
    if data.draw(st.booleans()):
        payload[6 if chosen.fd else 1] = 1 if chosen.fd else 0x90  # our version; classic: and the last part
    chosen.profile.protect(payload, chosen.base)
    codec = CanCodec(FINGERS, fd=chosen.fd)
    message = codec.decode(Frame(chosen.base, bytes(payload), chosen.fd, 1))
    waits = len(next(x for x in layouts().layouts if chosen in x.parts).parts) > 1
    assert message is not None or waits or sum(codec.rejected.values()) == 1


@given(st.text(), st.binary(max_size=200), st.integers())
def test_random_payloads_never_raise_and_are_no_messages(topic: str, payload: bytes, stamp: int) -> None:
    codec = MsgpackCodec()
    for name in (topic, *TOPICS):
        assert codec.decode(name, payload, stamp) is None
    assert sum(codec.rejected.values()) == 1 + len(TOPICS)


def protected(topic: str, body: bytes) -> bytes:
    route = Topics().incoming(topic)
    assert route is not None
    data = bytearray(P04_HEADER) + body
    P04.protect(data, route.data_id)
    return bytes(data)


@settings(max_examples=4 * settings().max_examples)
@given(topic=st.sampled_from(TOPICS), body=bodies)
def test_any_object_under_a_valid_checksum_never_raises(topic: str, body: object) -> None:
    codec = MsgpackCodec()
    message = codec.decode(topic, protected(topic, msgpack.packb(body)), 0)
    assert message is not None or sum(codec.rejected.values()) == 1


@given(topic=st.sampled_from(TOPICS), body=st.binary(max_size=300))
def test_any_bytes_under_a_valid_checksum_never_raise(topic: str, body: bytes) -> None:
    codec = MsgpackCodec()
    assert codec.decode(topic, protected(topic, body), 0) is None
    assert sum(codec.rejected.values()) == 1
