"""What goes in comes out, in every layout."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.messages import UNKNOWN, Estimate, FingertipState, ForceCommand, Message, Reason
from vegrip.transport.codec import CanCodec, MsgpackCodec
from vegrip.transport.codec.database import layouts
from vegrip.transport.codec.schema import message_set

FINGERS = ("thumb", "index", "middle", "ring", "little")
KINDS = tuple(message_set().messages)
ON_CAN = tuple(cls for cls, schema in message_set().messages.items() if schema.on_can)
STATE_FIELDS = [f.name for f in dataclasses.fields(FingertipState)][3:]

Messages = Callable[..., st.SearchStrategy[Message]]


def through_can(message: Message, fd: bool) -> Message | None:
    sender, receiver = (CanCodec(FINGERS, fd=fd, use_sender_time=True) for _ in range(2))
    sent = sender.encode(message)
    assert not any(frame.stamp for frame in sent)
    received = [receiver.decode(f._replace(stamp=message.stamp)) for f in sent]
    assert not receiver.rejected
    assert all(m is None for m in received[:-1])
    return received[-1] if received else None


def through_msgpack(message: Message) -> Message | None:
    sent = MsgpackCodec("left").encode(message)
    assert sent is not None
    return MsgpackCodec("left", FINGERS).decode(*sent, stamp=0)


@pytest.mark.parametrize("kind", ON_CAN)
@given(data=st.data())
def test_fd_frames_carry_every_float32_exactly(
    kind: type[Any], data: st.DataObject, messages: Messages
) -> None:
    message = data.draw(messages(kind))
    assert repr(through_can(message, fd=True)) == repr(message)


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_msgpack_carries_everything_exactly(kind: type[Any], data: st.DataObject, messages: Messages) -> None:
    message = data.draw(messages(kind))
    assert repr(through_msgpack(message)) == repr(message)


@given(value=st.floats(allow_infinity=False), field=st.sampled_from(STATE_FIELDS))
def test_msgpack_carries_float64(value: float, field: str) -> None:
    message = FingertipState(0, "ring", 0, **{field: value})
    assert repr(through_msgpack(message)) == repr(message)


def _steps() -> dict[str, tuple[float, float, float]]:
    parts = next(x for x in layouts().layouts if x.schema.cls is FingertipState and not x.fd).parts
    slots = {slot.name: slot.convert for part in parts for slot in part.slots}
    return {name: (c.scale, c.low * c.scale, c.high * c.scale) for name, c in slots.items()}  # type: ignore[attr-defined]


@pytest.mark.parametrize("field", STATE_FIELDS)
@given(share=st.floats(0, 1))
def test_classic_frames_carry_a_quantity_to_half_a_step(field: str, share: float) -> None:
    step, low, high = _steps()[field]
    value = low + share * (high - low)
    received = through_can(FingertipState(0, "thumb", 3, **{field: value}), fd=False)
    assert getattr(received, field) == pytest.approx(value, abs=0.5000001 * step)


@pytest.mark.parametrize("fd", [False, True])
def test_a_quantity_not_measured_stays_so_and_one_alone_arrives_alone(fd: bool) -> None:
    for field in STATE_FIELDS:
        for one, others in ((math.nan, 0.0), (0.0, math.nan)):
            state = FingertipState(0, "middle", 3, **dict.fromkeys(STATE_FIELDS, others) | {field: one})
            assert repr(through_can(state, fd=fd)) == repr(state)


@pytest.mark.parametrize("force", [1.0677e-10, 3.12e-7, 20.0, 500.0])
def test_fd_carries_nanonewtons_as_well_as_newtons(force: float) -> None:
    received = through_can(FingertipState(0, "thumb", 0, force), fd=True)
    assert received.normal_force == pytest.approx(force, rel=1e-7)  # type: ignore[union-attr]


@pytest.mark.parametrize("fd", [False, True])
def test_classic_and_fd_agree_on_ordinary_messages(fd: bool, examples: list[Message]) -> None:
    for message in examples:
        if type(message) not in ON_CAN:
            continue
        received = through_can(message, fd)
        for field in dataclasses.fields(message):
            got, want = getattr(received, field.name), getattr(message, field.name)
            if isinstance(got, Estimate) and got != UNKNOWN:
                assert got.value == pytest.approx(want.value, rel=0.01)
                assert got.std == math.inf or got.std == pytest.approx(want.std, rel=0.25)
                assert got.valid == want.valid
            elif isinstance(got, float) and not math.isnan(got):
                assert got == pytest.approx(want, rel=0.02)


def test_an_estimate_that_was_never_made_stays_unknown(messages: Messages) -> None:
    for kind in ON_CAN:
        for field in dataclasses.fields(kind):
            if field.default is UNKNOWN:
                message = kind(stamp=0, finger="thumb", seq=1)
                for received in (
                    through_can(message, True),
                    through_can(message, False),
                    through_msgpack(message),
                ):
                    assert repr(getattr(received, field.name)) == repr(UNKNOWN)


@pytest.mark.parametrize("fd", [False, True])
def test_what_is_not_told_on_can_gives_no_frame_and_is_no_fault(fd: bool, examples: list[Message]) -> None:
    silent = [message for message in examples if type(message) not in ON_CAN]
    codec = CanCodec(FINGERS, fd=fd)
    assert [codec.encode(message) for message in silent] == [[]]
    assert not codec.clipped


@pytest.mark.parametrize("fd", [False, True])
def test_words_without_a_code_become_other(fd: bool, examples: list[Message]) -> None:
    health = dataclasses.replace(examples[4], suspect="my_own_effect", channel="", regime="")  # type: ignore[call-arg]
    received = through_can(health, fd)
    assert (received.suspect, received.channel, received.regime) == ("other", "", "")  # type: ignore[union-attr]
    assert through_msgpack(health).suspect == "my_own_effect"  # type: ignore[union-attr]


def test_names_of_failures_without_a_signal_are_summed_as_other(examples: list[Message]) -> None:
    status = dataclasses.replace(examples[-1], rejected={"checksum": 3, "schema": 4, "state": 5})  # type: ignore[call-arg]
    assert through_can(status, fd=True).rejected == {"checksum": 3, "other": 9}  # type: ignore[union-attr]
    assert through_can(status, fd=False).rejected == {"other": 12}  # type: ignore[union-attr]


def test_the_bytes_of_a_finger_are_told_unless_more_than_the_bytes_matters() -> None:
    assert CanCodec(("thumb",), fd=True).line("thumb") is not None
    assert CanCodec(("thumb",), fd=False).line("thumb") is None
    assert CanCodec(("thumb",), fd=True).line("index") is None
    assert CanCodec(("thumb",), fd=True, hand_clock=lambda _, received: received).line("thumb") is None
    assert CanCodec(("thumb",), fd=True, reach=3).line("thumb") is None


@pytest.mark.parametrize(("lifetime", "steps"), [(0.1, 1000), (0.05, 500), (10.0, 0)])
def test_the_bytes_of_a_finger_are_told_by_identifiers_and_a_lifetime_in_steps(
    lifetime: float, steps: int
) -> None:
    codec = CanCodec(("thumb", "index"), fd=True)
    line, memory = codec.line("index"), dict[str, float]()
    assert line is not None
    line.write_to(memory, lifetime)
    sent = [
        codec.encode(one)[0].arbitration_id
        for one in (FingertipState(0, "index", 0), ForceCommand(0, "index", 0, 1.0, 0.0, Reason.HOLD, 0))
    ]
    assert [memory["SETUP_STATE_ID"], memory["SETUP_COMMAND_ID"]] == sent
    assert memory["SETUP_EXPIRES"] == steps
    assert line.carries(lifetime) == (steps > 0)


def test_a_stamp_that_comes_as_a_float_is_sent_as_a_whole_number() -> None:
    state = FingertipState(5e6, "ring", 7, 1.5)  # type: ignore[arg-type]
    assert repr(through_msgpack(state)) == repr(FingertipState(5_000_000, "ring", 7, 1.5))


def test_a_quantity_that_comes_as_a_whole_number_is_sent_as_a_float() -> None:
    _, payload = MsgpackCodec().encode(FingertipState(5, "ring", 7, 2)) or ("", b"")
    assert repr(msgpack.unpackb(payload[12:])["normal_force"]) == "2.0"
