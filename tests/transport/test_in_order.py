"""Order restored within the window, and no later; what comes in order never waits."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from validation.faults.simulated_can import SimulatedCan
from vegrip.clock import SimulatedClock
from vegrip.messages import FingertipState, NodeStatus
from vegrip.transport.can_endpoint import InOrder
from vegrip.transport.codec import CanCodec
from vegrip.transport.codec.sequence import Sequence
from vegrip.transport.sender_clock import SenderClock

MS = 1_000_000
WINDOW = 10 * MS


def state(seq, finger="thumb", stamp=None):
    return FingertipState(seq * MS if stamp is None else stamp, finger, seq, normal_force=1.0)


def passed(order, states, now):
    return [m.seq for m in order.restore(states, [now] * len(states), now)[0]]


def test_what_comes_in_order_passes_at_once():
    order = InOrder(WINDOW)
    assert [passed(order, [state(i)], i * MS) for i in range(5)] == [[0], [1], [2], [3], [4]]


def test_what_was_overtaken_takes_its_place():
    order = InOrder(WINDOW)
    assert passed(order, [state(1)], 1 * MS) == [1]
    assert passed(order, [state(3)], 3 * MS) == []
    assert passed(order, [state(2)], 4 * MS) == [2, 3]
    assert order.faults == {"reordered": 1}


def test_after_the_window_a_missing_one_is_given_up_and_late_if_it_comes():
    order = InOrder(WINDOW)
    passed(order, [state(1)], 1 * MS)
    assert passed(order, [state(3)], 3 * MS) == []
    assert passed(order, [], 12 * MS) == []
    assert passed(order, [], 13 * MS) == [3]
    assert passed(order, [state(2)], 14 * MS) == []
    assert order.faults == {"late": 1}
    assert passed(order, [state(4)], 15 * MS) == [4]


def test_fingers_do_not_wait_for_each_other_and_other_messages_never_wait():
    order = InOrder(WINDOW)
    passed(order, [state(1), state(1, "index")], 0)
    status = NodeStatus(0, "n", 0, 2)
    out, _ = order.restore([state(3), state(2, "index"), status], [0, 0, 0], 0)
    assert out == [state(2, "index"), status]


@given(st.permutations(range(12)))
def test_any_order_comes_out_in_order_and_stamped_in_order(order_of_arrival):
    """Arrival stamps are out of order where messages were; they are put between their neighbours."""
    order = InOrder(1000 * MS)
    order.restore([state(-1, stamp=0)], [0], 0)
    out = []
    for arrival, seq in enumerate(order_of_arrival, start=1):
        out += order.restore([state(seq, stamp=arrival * MS)], [arrival * MS], arrival * MS)[0]
    assert [m.seq for m in out] == list(range(12))
    assert all(b.stamp > a.stamp for a, b in pairwise(out))


def test_a_flood_of_wild_numbers_does_not_make_it_grow():
    order = InOrder(1000 * MS)
    order.restore([state(0)], [0], 0)
    for i in range(1000):
        order.restore([state(10 + 7 * i)], [1], 1)
    assert len(order._held["thumb"]) <= 32


@given(st.permutations(range(1, 9)))
def test_a_counter_with_reach_takes_each_of_a_shuffled_stream_once(order_of_arrival):
    stream = Sequence(2**32, reach=16)
    assert stream.advance(0, 0) == 0
    assert sorted(stream.advance(n, 0) for n in order_of_arrival) == list(range(1, 9))
    assert stream.lost == 0
    assert [stream.advance(n, 0) for n in order_of_arrival] == [None] * 8, "never twice"


def test_a_counter_takes_nothing_beyond_its_reach_and_nothing_from_before_its_start():
    stream = Sequence(2**32, reach=3)
    assert stream.advance(100, 0) == 100
    assert stream.advance(99, 0) is None
    assert stream.advance(110, 0) == 110
    assert stream.advance(107, 0) == 107
    assert stream.advance(106, 0) is None
    assert stream.lost == 8


@pytest.mark.parametrize("window", [0.0, 0.02])
def test_on_the_bus_overtaken_states_come_in_order_with_the_times_of_their_samples(window):
    bus = SimulatedCan(SimulatedClock())
    clock = SenderClock()
    codec = CanCodec(("thumb",), fd=True, hand_clock=clock.observe, reach=16 if window else 0)
    hand, node = bus.endpoint(CanCodec(("thumb",), fd=True)), bus.endpoint(codec, order_window=window)
    hand.tamper = lambda frame, now: [(now + (12 * MS if frame.data[2] % 5 == 0 else 0), frame)]
    got = []
    for seq in range(1, 401):
        hand.send(state(seq, stamp=seq * 5 * MS))
        got += node.receive(0.005)
        bus.clock.sleep_until(seq * 5 * MS)
    numbers = [m.seq for m in got]
    assert numbers == sorted(numbers)
    if window:
        assert len(numbers) >= 395
        assert {b - a for a, b in pairwise(numbers)} == {1}
        steps = {round((b.stamp - a.stamp) / MS, 1) for a, b in pairwise(got[60:])}
        assert steps == {5.0}
        assert node.rejected["reordered"] > 70
    else:
        assert node.rejected["counter"] > 70
