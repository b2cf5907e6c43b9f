"""Counters: a loss is counted, a repeat is refused, a sender may start again."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.messages import FingertipState
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.sequence import Sequence

MODULI = [15, 2**32]
FINGERS = ("thumb", "index")
MILLISECOND = 1_000_000


@pytest.mark.parametrize("modulus", MODULI)
@given(start=st.integers(0, 2**32 - 1), gaps=st.lists(st.integers(1, 7)))
def test_any_stream_with_losses_is_counted_through(modulus: int, start: int, gaps: list[int]) -> None:
    stream = Sequence(modulus)
    first = stream.advance(start % modulus, 0)
    seq = start
    for gap in gaps:
        seq += gap
        assert stream.advance(seq % modulus, 0) == (first or 0) + seq - start
    assert stream.lost == sum(gaps) - len(gaps)


@pytest.mark.parametrize("modulus", MODULI)
@given(start=st.integers(0, 100), back=st.integers(0, 7))
def test_a_repeat_or_a_step_back_is_refused_and_changes_nothing(modulus: int, start: int, back: int) -> None:
    stream = Sequence(modulus)
    for seq in range(start, start + 20):
        stream.advance(seq % modulus, 0)
    last = start + 19
    assert stream.advance((last - back) % modulus, 0) is None
    assert stream.advance((last + 1) % modulus, 0) is not None
    assert stream.lost == 0


@pytest.mark.parametrize("modulus", MODULI)
def test_half_of_all_counters_are_behind_the_last_one_and_none_before_the_first(modulus: int) -> None:
    stream = Sequence(modulus)
    assert not any(stream.is_behind(counter) for counter in (0, 1, modulus - 1))
    stream.advance(0, 0)
    behind = [stream.is_behind(counter) for counter in (0, 1, modulus // 2, modulus // 2 + 1, modulus - 1)]
    assert behind == [False, False, False, True, True]
    assert stream.advance(0, 0) is None


@pytest.mark.parametrize("modulus", MODULI)
def test_a_sender_that_starts_again_is_heard_after_a_silence(modulus: int) -> None:
    stream = Sequence(modulus)
    for seq in range(12):
        stream.advance(seq, seq * MILLISECOND)
    last = 11 * MILLISECOND
    assert stream.advance(0 if modulus > 15 else 9, last + 500_000_000) is None
    restarted = stream.advance(0 if modulus > 15 else 9, last + 500_000_000 + 1)
    assert restarted is not None
    assert restarted > 11, "the running number never runs backwards"
    assert stream.lost == 0, "what a restart has skipped is not known, hence not counted"


@given(start=st.integers(0, 2**32 - 1), jump=st.integers(10_000 + 2, 2**32 - 1))
def test_one_wrong_counter_neither_ends_its_stream_nor_counts_as_lost(start: int, jump: int) -> None:
    stream = Sequence(2**32)
    counters = [start, start + 1, start + 1 + jump, start + 2, start + 3]
    taken = [stream.advance(counter % 2**32, MILLISECOND * i) for i, counter in enumerate(counters)]
    assert taken == [start, start + 1, None, start + 2, start + 3]
    assert stream.lost == 0


@pytest.mark.parametrize("jump", [10_000 + 2, 2**31, 2**31 + 1, 2**32 - 1000])
def test_a_sender_that_goes_on_elsewhere_is_heard_after_the_silence_of_its_old_numbers(jump: int) -> None:
    stream = Sequence(2**32)
    stream.advance(7, 0)
    heard = [stream.advance((7 + jump + i) % 2**32, (1 + i) * 5 * MILLISECOND) for i in range(200)]
    first = next(i for i, seq in enumerate(heard) if seq is not None)
    assert (1 + first) * 5 * MILLISECOND > 500_000_000 >= first * 5 * MILLISECOND
    assert None not in heard[first:]
    assert stream.lost == 0


def test_a_sender_that_stands_still_is_never_heard_again() -> None:
    stream = Sequence(2**32)
    stream.advance(5, 0)
    assert [stream.advance(5, stamp * 500_000_000) for stamp in range(1, 100)] == [None] * 99


@pytest.mark.parametrize("fd", [False, True])
def test_a_replayed_stretch_of_traffic_is_refused(fd: bool) -> None:
    sender, receiver = (CanCodec(FINGERS, fd=fd) for _ in range(2))
    traffic = [
        frame._replace(stamp=2 * seq * MILLISECOND)
        for seq in range(30)
        for frame in sender.encode(FingertipState(0, "thumb", seq, 1.0, 0.1, 0.2, 0.001))
    ]
    received = [receiver.decode(frame) for frame in traffic]
    assert sum(m is not None for m in received) == 30
    window = traffic[-len(traffic) * 7 // 30 :]  # what a counter of 15 can tell from new traffic
    assert all(receiver.decode(frame) is None for frame in window)
    assert receiver.rejected == {"counter": len(window)}
    assert receiver.lost == 0


def test_every_finger_and_kind_counts_by_itself() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=True) for _ in range(2))
    for seq in (5, 6):
        for finger in FINGERS:
            for frame in sender.encode(FingertipState(0, finger, seq)):
                assert receiver.decode(frame) is not None
    assert (receiver.rejected, receiver.lost) == ({}, 0)


def test_the_sequence_number_of_an_fd_frame_wraps_without_a_step_back() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=True) for _ in range(2))
    frames = [sender.encode(FingertipState(0, "thumb", seq))[0] for seq in range(2**32 - 2, 2**32 + 2)]
    assert [m.seq for m in map(receiver.decode, frames) if m] == list(range(2**32 - 2, 2**32 + 2))


def test_the_sequence_number_of_a_payload_wraps_without_a_step_back() -> None:
    sender, receiver = MsgpackCodec(), MsgpackCodec()
    sent = [
        sender.encode(FingertipState(0, "thumb", seq)) or ("", b"") for seq in (2**32 - 1, 2**32, 2**32 + 1)
    ]
    assert [m.seq for p in sent if (m := receiver.decode(*p, stamp=0))] == [2**32 - 1, 2**32, 2**32 + 1]


def test_a_replayed_payload_is_refused() -> None:
    sender, receiver = MsgpackCodec(), MsgpackCodec()
    payloads = [p for seq in range(10) if (p := sender.encode(FingertipState(0, "thumb", seq)))]
    assert all(receiver.decode(*p, stamp=0) for p in payloads)
    assert not any(receiver.decode(*p, stamp=0) for p in payloads)
    assert receiver.rejected == {"counter": 10}


@given(order=st.permutations(range(1, 12)), reach=st.integers(1, 4))
def test_what_was_overtaken_by_few_enough_is_taken_once_under_its_own_number(
    order: list[int], reach: int
) -> None:
    stream = Sequence(2**32, reach)
    stream.advance(0, 0)
    last, taken = 0, {0}
    for counter in [*order, *order]:
        good = counter not in taken and counter >= last - reach
        assert stream.advance(counter, 0) == (counter if good else None)
        taken |= {counter} if good else set()
        last = max(last, counter) if good else last
    assert stream.lost == last + 1 - len(taken)


def test_the_first_message_is_not_taken_a_second_time_behind_later_ones() -> None:
    stream = Sequence(2**32, reach=2)
    assert [stream.advance(counter, 0) for counter in (3, 4, 3, 5, 3)] == [3, 4, None, 5, None]
    assert stream.lost == 0


@pytest.mark.parametrize("modulus", MODULI)
def test_without_a_reach_what_was_overtaken_stays_lost(modulus: int) -> None:
    stream = Sequence(modulus)
    assert [stream.advance(counter, 0) for counter in (3, 5, 4, 6)] == [3, 5, None, 6]
    assert stream.lost == 1


def test_after_a_silence_nothing_was_overtaken_and_nothing_is_lost() -> None:
    stream = Sequence(2**32, reach=2)
    for counter in (3, 5):
        stream.advance(counter, 0)
    assert stream.advance(4, 500_000_000) == 4
    assert stream.lost == 0
    stream = Sequence(2**32, reach=2)
    for counter in (3, 5):
        stream.advance(counter, 0)
    assert stream.advance(4, 500_000_001) == 5 + 2**32 - 1
    assert stream.lost == 1


def test_what_is_known_of_numbers_taken_does_not_grow() -> None:
    stream = Sequence(2**32, reach=3)
    for counter in range(1000):
        stream.advance(counter, 0)
    assert stream._seen < 2**8


@given(kept=st.sets(st.integers(0, 39)))
def test_lost_and_received_add_up(kept: set[int]) -> None:
    sender, receiver = MsgpackCodec(), MsgpackCodec()
    for seq in range(40):
        topic, payload = sender.encode(FingertipState(0, "thumb", seq)) or ("", b"")
        if seq in kept:
            assert receiver.decode(topic, payload, 0) is not None
    expected = max(kept) - min(kept) + 1 - len(kept) if kept else 0
    assert receiver.lost == expected


def test_a_frame_refused_for_its_checksum_counts_as_lost_when_the_next_comes() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=True) for _ in range(2))
    frames = [sender.encode(FingertipState(0, "thumb", seq))[0] for seq in range(3)]
    receiver.decode(frames[0])
    receiver.decode(Frame(frames[1].arbitration_id, bytes(48), fd=True))
    receiver.decode(frames[2])
    assert (receiver.rejected, receiver.lost) == ({"checksum": 1}, 1)


@pytest.mark.parametrize(("step", "is_taken"), [(9_999, True), (10_000, True), (10_001, False)])
def test_ten_thousand_messages_on_is_the_farthest_that_a_stream_goes_at_once(
    step: int, is_taken: bool
) -> None:
    stream = Sequence(2**32)
    stream.advance(7, 0)
    assert stream.advance(7 + step, MILLISECOND) == (7 + step if is_taken else None)
    assert stream.lost == (step - 1 if is_taken else 0)
