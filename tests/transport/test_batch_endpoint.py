"""What nobody waits for goes out behind what somebody does."""

import time
from collections.abc import Iterator
from contextlib import closing

import pytest

from vegrip.messages import Condition, ForceCommand, Message, ModelHealth, Reason, SlipMargin
from vegrip.transport.open import Hand, open_endpoint
from vegrip.transport.zmq_endpoint import BatchEndpoint

FINGERS = ("thumb", "index")
PATIENCE_S = 30.0
Pair = tuple[BatchEndpoint, BatchEndpoint]


@pytest.fixture
def pair(runtime: object) -> Iterator[Pair]:
    """Two that have met: what the first publishes the second hears."""
    tables = (
        {"kind": "zmq", "batch": True, "publish": "ipc:grip", "subscribe": ()},
        {"kind": "zmq", "batch": True, "publish": "ipc:hand", "subscribe": ("ipc:grip",)},
    )
    ours, theirs = (open_endpoint(table, Hand(FINGERS)) for table in tables)
    assert isinstance(ours, BatchEndpoint)
    assert isinstance(theirs, BatchEndpoint)
    with closing(ours), closing(theirs):
        seq, deadline = 0, time.monotonic() + PATIENCE_S
        while not theirs.receive(0.01) and time.monotonic() < deadline:
            seq += 1
            ours.send(health(seq))
        while theirs.receive(0.01):
            pass
        yield ours, theirs


def health(seq: int) -> ModelHealth:
    return ModelHealth(time.monotonic_ns(), "index", seq, Condition.OK)


def command(seq: int) -> ForceCommand:
    now = time.monotonic_ns()
    return ForceCommand(now, "index", seq, 1.0, 0.0, Reason.HOLD, now + 50_000_000)


def heard(theirs: BatchEndpoint, count: int) -> list[type[Message]]:
    """Return the kinds of the next ``count`` messages, in the order in which they came."""
    found: list[type[Message]] = []
    deadline = time.monotonic() + PATIENCE_S
    while len(found) < count and time.monotonic() < deadline:
        found += map(type, theirs.receive(0.1))
    return found


def test_what_is_put_off_follows_the_next_batch(pair: Pair) -> None:
    ours, theirs = pair
    ours.put_off(SlipMargin(time.monotonic_ns(), "index", 1))
    ours.put_off(health(10_000))
    frames = ours.batches.encode(command(1))
    ours.send_batch(ForceCommand, ours.batches.pack(ForceCommand, frames))
    assert heard(theirs, 3) == [ForceCommand, SlipMargin, ModelHealth]


def test_what_is_put_off_goes_out_with_the_next_flush_even_if_no_batch_comes(pair: Pair) -> None:
    ours, theirs = pair
    ours.put_off(health(10_000))
    ours.send(command(1))
    ours.flush()
    ours.flush()
    assert heard(theirs, 2) == [ForceCommand, ModelHealth]
    assert not theirs.receive(0.0)


def test_what_cannot_be_sent_is_counted_when_it_is_put_off(pair: Pair) -> None:
    ours, _ = pair
    ours.put_off(ModelHealth(1, "nose", 0))
    ours.put_off(SlipMargin(1, "nose", 0))
    assert ours.batches.clipped["finger"] == 1
    assert sum(ours.rejected.values()) >= 2
