"""cantools, which knows nothing of our plans, reads and writes the same frames."""

import math
from typing import Any

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vegrip.messages import FingertipState, Message
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.database import Part, database, layouts
from vegrip.transport.codec.schema import read_proto
from vegrip.transport.codec.signals import compiled

FINGERS = ("thumb", "index")
PARTS = {part.name: part for layout in layouts().layouts for part in layout.parts}


def plain(value: Any) -> Any:
    """Return the number behind a cantools choice."""
    return value.value if hasattr(value, "value") else value


def peer_decode(name: str, data: bytes) -> dict[str, Any]:
    return {k: plain(v) for k, v in database().get_message_by_name(name).decode(data).items()}


def ours_decode(part: Part, data: bytes) -> dict[str, Any]:
    cells = part.packer.unpack(data)
    return {slot.name: slot.convert.read(slot.place.get(cells)) for slot in part.slots}


@pytest.mark.parametrize("name", PARTS)
@settings(max_examples=50)
@given(data=st.data())
def test_every_signal_reads_as_cantools_reads_it(name: str, data: st.DataObject) -> None:
    part = PARTS[name]
    payload = data.draw(st.binary(min_size=part.length, max_size=part.length))
    theirs = peer_decode(name, payload)
    for slot, got in ((s, ours_decode(part, payload)[s.name]) for s in part.slots):
        want = theirs[slot.name]
        if got is None or isinstance(got, str) or math.isnan(want):
            continue  # refused, a word (see test_database), or not measured
        if slot.convert.read(slot.convert.absent) is got or not math.isfinite(got):
            continue  # set aside: a code of its own in the value table
        assert got == pytest.approx(want, rel=1e-12)


@pytest.mark.parametrize("fd", [False, True])
def test_what_we_send_reads_as_cantools_reads_it(fd: bool, examples: list[Message]) -> None:
    for message in examples:
        for frame in CanCodec(FINGERS, fd=fd).encode(message):
            base = frame.arbitration_id & ~0x3F
            part = next(p for p in PARTS.values() if p.base == base)
            theirs = peer_decode(part.name, frame.data)
            assert theirs["version"] == 1
            for slot in part.slots:
                want = compiled([f"def made(m): return {slot.text}"], {})(message)
                if isinstance(want, (int, float)) and not isinstance(want, bool) and math.isfinite(want):
                    tolerance = getattr(slot.convert, "scale", 1e-6 * abs(want))
                    assert theirs[slot.name] == pytest.approx(float(want), abs=1.01 * tolerance)


@pytest.mark.parametrize("name", PARTS)
def test_the_layout_is_the_one_cantools_writes(name: str, examples: list[Message]) -> None:
    """Decode a frame of ours with cantools, encode that again with cantools: the same bytes."""
    part = PARTS[name]
    for message in examples:
        for frame in CanCodec(FINGERS, fd=part.fd).encode(message):
            if frame.arbitration_id & ~0x3F == part.base:
                peer = database().get_message_by_name(name)
                decoded = peer.decode(frame.data, decode_choices=False, scaling=False)
                assert peer.encode(decoded, scaling=False, strict=False) == frame.data
                return
    pytest.fail(f"no example makes a frame {name}")


@pytest.mark.parametrize("force", [0.0, 1.5, -2.25])
def test_a_state_written_by_cantools_is_read(force: float) -> None:
    peer = database().get_message_by_name("FingertipStateFd")
    signals = dict.fromkeys((s.name for s in peer.signals), math.nan)
    signals |= {"crc": 0, "seq": 41, "version": 1, "time": 5, "last": 1, "normal_force": force}
    data = bytearray(peer.encode({s.name: signals[s.name] for s in peer.signals}))
    identifier = peer.frame_id + 1
    PARTS["FingertipStateFd"].profile.protect(data, identifier)
    received = CanCodec(FINGERS, fd=True).decode(Frame(identifier, bytes(data), fd=True, stamp=9))
    assert repr(received) == repr(FingertipState(9, "index", 41, force))


def test_every_kind_and_layout_has_been_compared() -> None:
    assert set(PARTS) == {message.name for message in database().messages}


def test_the_mask_of_the_readme_lets_cantools_see_every_finger_and_hand(examples: list[Message]) -> None:
    masked = cantools.database.load_string(read_proto("fingertip.dbc"), "dbc", frame_id_mask=0x7C0)
    (frame,) = CanCodec(FINGERS, fd=True, hand=5).encode(examples[3])
    peer = masked.get_message_by_frame_id(frame.arbitration_id)  # type: ignore[union-attr]
    assert plain(peer.decode(frame.data)["reason"]) == 1  # type: ignore[index,call-overload]
