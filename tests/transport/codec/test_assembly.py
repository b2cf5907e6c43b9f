"""A classic state is several frames: it arrives whole and of one cycle, or not at all."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.messages import ContactEstimate, FingertipState, Message
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.database import layouts
from vegrip.transport.codec.frame_codec import Assembly, Whole

FINGERS = ("thumb", "index")
PERIOD = 2_000_000  # [ns]


def cycle(sender: CanCodec, seq: int, finger: str = "thumb") -> list[Frame]:
    """Return the three frames of a state whose quantities all tell the cycle: seq in each of them."""
    state = FingertipState(
        *(0, finger, seq, seq * 1e-3, seq * 1e-3, seq * 1e-3, seq * 1e-5, seq * 1e-6),
        *(seq * 0.01, 1.0, seq * 1e-5, seq * 5e-7),
    )
    return [frame._replace(stamp=seq * PERIOD) for frame in sender.encode(state)]


def cycles_in(state: Message | None) -> set[int]:
    assert isinstance(state, FingertipState)
    return {
        *(round(state.normal_force / 1e-3), round(state.tangential_force_y / 1e-3)),
        *(round(state.torque_z / 1e-5), round(state.displacement / 1e-6)),
        *(
            round(state.temperature / 0.01),
            round(state.slip_speed / 1e-5),
            round(state.contact_radius / 5e-7),
        ),
    }


@given(dropped=st.sets(st.integers(0, 89)))
def test_a_state_is_never_put_together_from_two_cycles(dropped: set[int]) -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    frames = [frame for seq in range(30) for frame in cycle(sender, seq)]
    received = [receiver.decode(f) for i, f in enumerate(frames) if i not in dropped]
    got = [cycles_in(state) for state in received if state is not None]
    whole = [seq for seq in range(30) if not dropped & {3 * seq, 3 * seq + 1, 3 * seq + 2}]
    assert all(len(seqs) == 1 for seqs in got)
    assert [seq for seqs in got for seq in seqs] == expected_after_counter(whole, dropped)


def expected_after_counter(whole: list[int], dropped: set[int]) -> list[int]:
    """Leave out what follows a gap of 7 cycles or more: a counter of 15 cannot tell it from a step back."""
    heads = [seq for seq in range(30) if 3 * seq not in dropped]
    accepted: list[int] = []
    for seq in heads:
        if not accepted or 1 <= (seq - accepted[-1]) % 15 <= 7:
            accepted.append(seq)
    return [seq for seq in whole if seq in accepted]


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_a_missing_part_costs_one_state_and_no_more(missing: int) -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    frames = [frame for seq in range(3) for frame in cycle(sender, seq)]
    del frames[3 + missing]
    states = [state for state in map(receiver.decode, frames) if state is not None]
    assert [cycles_in(state) for state in states] == [{0}, {2}]
    assert receiver.lost == 1


def test_a_part_of_a_message_that_was_never_begun_is_incomplete_whatever_its_counter() -> None:
    """No counter stands for a message that has been."""
    sender = CanCodec(FINGERS, fd=False)
    for seq in range(15):
        receiver = CanCodec(FINGERS, fd=False)
        assert [receiver.decode(frame) for frame in cycle(sender, seq)[1:]] == [None, None]
        assert receiver.rejected == {"incomplete": 2}


@pytest.mark.parametrize("finger", FINGERS)
def test_interleaved_fingers_do_not_disturb_each_other(finger: str) -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    pairs = zip(cycle(sender, 3, "thumb"), cycle(sender, 4, "index"), strict=True)
    states = [state for pair in pairs for frame in pair if (state := receiver.decode(frame))]
    assert [(s.finger, cycles_in(s)) for s in states if isinstance(s, FingertipState)] == [
        ("thumb", {3}),
        ("index", {4}),
    ]


def test_a_part_after_fifteen_silent_cycles_is_not_taken_for_the_present_one() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    assert receiver.decode(cycle(sender, 0)[0]) is None
    late = [frame._replace(stamp=5_000_001) for frame in cycle(sender, 15)[1:]]
    assert [receiver.decode(frame) for frame in late] == [None, None]
    assert receiver.rejected["incomplete"] >= 1


def test_a_repeated_part_is_refused_and_the_state_still_completes() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    first, second, third = cycle(sender, 1)
    received = [receiver.decode(frame) for frame in (first, first, second, second, first, third)]
    assert [state is not None for state in received] == [False] * 5 + [True]
    assert receiver.rejected == {"counter": 3}


def test_parts_without_anything_measured_are_not_sent() -> None:
    sender = CanCodec(FINGERS, fd=False)
    assert len(sender.encode(FingertipState(0, "thumb", 0))) == 1
    assert len(sender.encode(FingertipState(0, "thumb", 0, normal_force=1.0))) == 1
    assert len(sender.encode(FingertipState(0, "thumb", 0, displacement=1e-3))) == 2
    assert len(sender.encode(FingertipState(0, "thumb", 0, temperature=30.0))) == 3
    for fd in (False, True):
        assert len(CanCodec(FINGERS, fd=fd).encode(ContactEstimate(0, "thumb", 0))) == 1


def test_a_state_in_fewer_parts_forgets_what_the_last_one_measured() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    for frame in cycle(sender, 0):
        receiver.decode(frame)
    state = receiver.decode(sender.encode(FingertipState(0, "thumb", 1, normal_force=2.0))[0])
    assert isinstance(state, FingertipState)
    assert state.normal_force == 2.0
    assert math.isnan(state.torque_z)
    assert math.isnan(state.contact_radius)


def test_the_last_of_all_parts_completes_a_state_even_where_it_does_not_say_so() -> None:
    parts = next(x.parts for x in layouts().layouts if x.schema.cls is FingertipState and not x.fd)
    assembly = Assembly(parts, 0)
    cells = [(part.number,) * part.cells for part in parts]
    told = [assembly.put(number, 4, False, cells[number - 1], 7 + number, 0) for number in (1, 2, 3)]
    assert told == [None, None, Whole(sum(cells, ()), 4, 8, 0)]


def test_the_stamp_is_that_of_the_first_part() -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    frames = [f._replace(stamp=100 + i) for i, f in enumerate(cycle(sender, 1))]
    assert [m.stamp for m in map(receiver.decode, frames) if m] == [100]


@pytest.mark.parametrize(
    ("late", "whole"), [(4_900_000, True), (5_000_000, True), (5_000_001, False), (7_500_000, False)]
)
def test_a_part_may_be_late_but_not_by_the_fifteen_cycles_of_a_counter_at_2_khz(
    late: int, whole: bool
) -> None:
    sender, receiver = (CanCodec(FINGERS, fd=False) for _ in range(2))
    received = [
        receiver.decode(frame._replace(stamp=late if i else 0)) for i, frame in enumerate(cycle(sender, 1))
    ]
    assert (received[-1] is not None) == whole
