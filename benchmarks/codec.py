"""Bytes to a message and back: our codec against the same done by hand with cantools.

Both check or compute the E2E checksum and make the message or the frame; ours also checks version, length,
counter and range. Each call takes a batch with running counters, so that every message is accepted. The
msgpack round trip is compared with that of an FD frame.
"""

import dataclasses
from collections.abc import Callable, Sequence
from itertools import count
from typing import Any

from benchmarks._timing import compared
from vegrip.messages import FingertipState, ForceCommand, Message, Reason
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.database import Part, database, layouts
from vegrip.transport.codec.protection import CAN_PROFILES
from vegrip.transport.codec.sequence import RESYNC

FINGERS = ("thumb", "index", "middle", "ring", "little")
BATCH = 100
QUANTITIES = [field.name for field in dataclasses.fields(FingertipState)][3:]
MILLISECOND = 1_000_000

Timed = dict[str, float]


def state(seq: int) -> FingertipState:
    return FingertipState(
        seq * MILLISECOND, "thumb", seq, 4.0, 0.5, -0.25, 0.002, 0.001, 31.5, 0.0, 0.001, 0.004
    )


def command(seq: int) -> ForceCommand:
    stamp = seq * MILLISECOND
    return ForceCommand(stamp, "thumb", seq, 4.2, 0.2, Reason.RAISE, stamp + 50 * MILLISECOND)


def run() -> dict[str, Timed]:
    results: dict[str, Timed] = {}
    for layout, fd in (("fd", True), ("classic", False)):
        for kind, make in (("state", state), ("command", command)):
            messages = [make(seq) for seq in range(BATCH)]
            name = f"codec_{layout}_{kind}"
            results[f"{name}_decode_vs_cantools"] = each(decoding(messages, fd), peer_decoding(messages, fd))
            results[f"{name}_encode_vs_cantools"] = each(encoding(messages, fd), peer_encoding(messages, fd))
    states = [state(seq) for seq in range(BATCH)]
    results["codec_msgpack_vs_fd_state_round_trip"] = each(round_trip_topics(states), round_trip_fd(states))
    return results


def each(ours: Callable[[], object], theirs: Callable[[], object]) -> Timed:
    """Time two batches; the times are for one message."""
    batch = compared(ours, theirs)
    return {
        "ours_us": batch["ours_us"] / BATCH,
        "theirs_us": batch["theirs_us"] / BATCH,
        "ratio": batch["ratio"],
    }


def frames(messages: Sequence[Message], fd: bool) -> list[Frame]:
    sender = CanCodec(FINGERS, fd=fd)
    return [frame for message in messages for frame in sender.encode(message)]


def decoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    receiver, sent = CanCodec(FINGERS, fd=fd), frames(messages, fd)

    def decode() -> int:
        begin_again(receiver)
        return sum(receiver.decode(frame) is not None for frame in sent)

    assert decode() == BATCH
    return decode


def begin_again(receiver: CanCodec) -> None:
    """Have it take the next messages as the first ones."""
    for decoder in receiver._decoders.values():
        decoder.assembly.sequence.last = -1


def encoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    sender = CanCodec(FINGERS, fd=fd)
    return lambda: [sender.encode(message) for message in messages]


def peer_decoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    batches = [frames([message], fd) for message in messages]
    return lambda: [peer_message(batch) for batch in batches]


def peer_message(batch: Sequence[Frame]) -> Message:
    values: dict[str, Any] = {}
    for frame in batch:
        profile = CAN_PROFILES["P05" if frame.fd else "P11"]
        assert profile.check(frame.data, frame.arbitration_id)
        decoded: Any = database().decode_message(frame.arbitration_id, frame.data, decode_choices=False)
        values |= decoded
    seq = values["seq"] if "seq" in values else values["counter"]
    if "expires" in values:
        expires = round(values["expires"] * 1e9)
        force, adjustment = values["normal_force"], values["adjustment"]
        return ForceCommand(0, "thumb", seq, force, adjustment, Reason(values["reason"]), expires)
    return FingertipState(0, "thumb", seq, *[values[name] for name in QUANTITIES])


def peer_encoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    layout = next(x for x in layouts().layouts if x.fd == fd and x.schema.cls is type(messages[0]))
    return lambda: [peer_frames(layout.parts, message) for message in messages]


def peer_frames(parts: Sequence[Part], message: Any) -> list[Frame]:
    header = {"crc": 0, "seq": message.seq, "counter": message.seq % 15, "version": 1}
    values = header | {"time": message.stamp // 1000 % 2**32}
    if isinstance(message, ForceCommand):
        values |= {"normal_force": message.normal_force, "adjustment": message.adjustment}
        values |= {"reason": int(message.reason), "expires": (message.expires - message.stamp) / 1e9}
    else:
        values |= {name: getattr(message, name) for name in QUANTITIES}
    return [peer_frame(part, values | {"last": part is parts[-1]}) for part in parts]


def peer_frame(part: Part, values: dict[str, Any]) -> Frame:
    data = bytearray(database().encode_message(part.base, values, strict=False))
    part.profile.protect(data, part.base)
    return Frame(part.base, bytes(data), part.fd)


def round_trip_topics(messages: Sequence[Message]) -> Callable[[], object]:
    sender, receiver, stamps = MsgpackCodec(), MsgpackCodec(), count(0, 2 * RESYNC)

    def send() -> int:
        stamp = next(stamps)
        payloads = [sent for message in messages if (sent := sender.encode(message))]
        return sum(receiver.decode(*sent, stamp=stamp) is not None for sent in payloads)

    assert send() == BATCH
    return send


def round_trip_fd(messages: Sequence[Message]) -> Callable[[], object]:
    sender, receiver = CanCodec(FINGERS, fd=True), CanCodec(FINGERS, fd=True)

    def send() -> int:
        begin_again(receiver)
        sent = [frame for message in messages for frame in sender.encode(message)]
        return sum(receiver.decode(frame) is not None for frame in sent)

    assert send() == BATCH
    return send
