"""States packed together are, byte for byte, those that the encoder makes of messages."""

import math
from collections import Counter

import numpy as np
import pytest

from vegrip.hand_sample import HandSample
from vegrip.transport.codec import CanCodec
from vegrip.transport.codec.convert import FLOAT32_MAX
from vegrip.transport.codec.state_rows import StateRows

FINGERS = ("thumb", "index", "middle", "ring", "little")
AWKWARD = [
    math.nan, -math.nan, 0.0, -0.0, math.inf, -math.inf, 1e-46, 1e-40, 1.0 / 3.0, -1e300, FLOAT32_MAX,
    -FLOAT32_MAX, math.nextafter(FLOAT32_MAX, math.inf), 16777217.0, 1.0 + 2.0**-24, 3.4e38,
]  # fmt: skip


def rows_of(codec: CanCodec, fingers: tuple[str, ...] = FINGERS) -> StateRows:
    rows = codec.state_rows(fingers)
    assert rows is not None
    return rows


def sample(seed: int, seq: int, lost: float = 0.0) -> HandSample:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((5, 9)) * 10.0 ** rng.integers(-6, 3, (5, 9))
    values[:, rng.integers(9)] = math.nan
    places = rng.random((5, 9)) < 0.2
    values[places] = rng.choice(AWKWARD, places.sum())
    return HandSample(seq, rng.integers(0, 2**62, 5), values, rng.random(5) < lost)


@pytest.mark.parametrize("hand", [0, 3])
@pytest.mark.parametrize("seq", [0, 1, 255, 2**16, 2**32 - 1, 2**32, 2**40 + 7])
def test_frames_and_counts_are_those_of_the_encoder(hand: int, seq: int) -> None:
    ours, theirs = (CanCodec(FINGERS, fd=True, hand=hand) for _ in range(2))
    rows = rows_of(ours)
    packed = np.zeros((5, rows.length + 3), np.uint8)
    rows.prepare(packed)
    for seed in range(40):
        given = sample(seed, seq)
        rows.pack(packed, given)
        frames = [frame for state in given.states(FINGERS) for frame in theirs.encode(state)]
        assert [frame.arbitration_id for frame in frames] == list(rows.identifiers)
        assert [row.tobytes() for row in packed[:, : rows.length]] == [frame.data for frame in frames]
    assert ours.clipped == theirs.clipped != Counter()


def test_what_is_lost_is_left_as_it_was_and_not_counted() -> None:
    ours, theirs = (CanCodec(FINGERS, fd=True) for _ in range(2))
    rows = rows_of(ours)
    packed = np.zeros((5, rows.length), np.uint8)
    rows.prepare(packed)
    for seed in range(40):
        given, before = sample(seed, seed, lost=0.5), packed.copy()
        rows.pack(packed, given)
        assert np.array_equal(packed[given.lost], before[given.lost])
        frames = [frame for state in given.states(FINGERS) for frame in theirs.encode(state)]
        assert [row.tobytes() for row in packed[~given.lost]] == [frame.data for frame in frames]
    assert ours.clipped == theirs.clipped


def test_fingers_may_be_some_of_those_of_the_bus_in_any_order() -> None:
    codec = CanCodec(FINGERS, fd=True)
    rows = rows_of(codec, ("ring", "thumb"))
    packed = np.zeros((2, rows.length), np.uint8)
    rows.prepare(packed)
    given = HandSample(7, np.array([5000, 9000]), np.full((2, 9), 0.5), np.zeros(2, bool))
    rows.pack(packed, given)
    frames = [frame for state in given.states(("ring", "thumb")) for frame in codec.encode(state)]
    assert [row.tobytes() for row in packed] == [frame.data for frame in frames]
    assert [frame.arbitration_id for frame in frames] == list(rows.identifiers)


def test_there_are_none_in_classic_frames_or_for_fingers_that_the_bus_does_not_know() -> None:
    assert CanCodec(FINGERS, fd=False).state_rows(FINGERS) is None
    assert CanCodec(FINGERS, fd=True).state_rows((*FINGERS, "tail")) is None
