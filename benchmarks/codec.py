"""Frames and messages: our codec against cantools' ``decode_message`` and ``encode_message``.

What is compared is not the same work: ours also checks or computes the E2E checksum, checks version, length
and counter, and makes the message; cantools turns bytes into a dictionary and back. Each call takes a batch
of frames with running counters, so that every one of them is accepted.
"""

from collections.abc import Callable, Sequence
from typing import Any

from vegrip.benchmarks._timing import compared

from vegrip.codec import CanCodec, Frame, MsgpackCodec
from vegrip.codec.layout import database
from vegrip.messages import FingertipState, ForceCommand, Message, Reason

FINGERS = ("thumb", "index", "middle", "ring", "little")
BATCH = 100
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
        receiver.reset()
        return sum(receiver.decode(frame) is not None for frame in sent)

    assert decode() == BATCH
    return decode


def encoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    sender = CanCodec(FINGERS, fd=fd)
    return lambda: [sender.encode(message) for message in messages]


def peer_decoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    db, sent = database(), frames(messages, fd)
    return lambda: [db.decode_message(frame.arbitration_id, frame.data) for frame in sent]


def peer_encoding(messages: Sequence[Message], fd: bool) -> Callable[[], object]:
    db = database()
    signals: list[tuple[int, Any]] = [
        (frame.arbitration_id, db.decode_message(frame.arbitration_id, frame.data))
        for frame in frames(messages, fd)
    ]
    return lambda: [db.encode_message(identifier, values) for identifier, values in signals]


def round_trip_topics(messages: Sequence[Message]) -> Callable[[], object]:
    sender, receiver = MsgpackCodec(), MsgpackCodec()

    def send() -> int:
        receiver.reset()
        payloads = [sent for message in messages if (sent := sender.encode(message))]
        return sum(receiver.decode(*sent, stamp=0) is not None for sent in payloads)

    assert send() == BATCH
    return send


def round_trip_fd(messages: Sequence[Message]) -> Callable[[], object]:
    sender, receiver = CanCodec(FINGERS, fd=True), CanCodec(FINGERS, fd=True)

    def send() -> int:
        receiver.reset()
        sent = [frame for message in messages for frame in sender.encode(message)]
        return sum(receiver.decode(frame) is not None for frame in sent)

    assert send() == BATCH
    return send
