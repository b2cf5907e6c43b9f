"""The simulated bus: real frame times on a clock that nobody waits for."""

import pytest

from validation.faults.simulated_can import SimulatedCan
from vegrip.clock import SimulatedClock
from vegrip.messages import FingertipState
from vegrip.transport.canbus.bus_events import ErrorState, NodeFaults
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame, frame_duration
from vegrip.transport.codec import CanCodec

FINGERS = ("thumb", "index")
MS = 1_000_000


def codec(fd=True):
    return CanCodec(FINGERS, fd=fd)


def state(seq, finger="thumb"):
    return FingertipState(stamp=seq * MS, finger=finger, seq=seq, normal_force=1.5, tangential_force_x=0.25)


@pytest.fixture
def bus():
    return SimulatedCan(SimulatedClock())


def test_a_message_arrives_when_its_last_bit_has_passed(bus):
    hand, node = bus.endpoint(codec()), bus.endpoint(codec())
    (frame,) = codec().encode(state(1))
    hand.send(state(1))
    (got,) = node.receive(1.0)
    sent = BusFrame(frame.arbitration_id, frame.data, fd=True, has_bit_rate_switch=True)
    assert got.normal_force == 1.5
    assert node.arrivals == [frame_duration(sent, BitTiming())] == [bus.clock.now()]
    assert not hand.receive(0.0), "a node does not hear itself"


def test_waiting_moves_the_clock_and_no_further_than_asked(bus):
    node = bus.endpoint(codec())
    assert node.receive(0.25) == []
    assert bus.clock.now() == 250 * MS


def test_the_parts_of_a_classic_message_follow_each_other(bus):
    hand, node = bus.endpoint(codec(fd=False)), bus.endpoint(codec(fd=False))
    whole = FingertipState(stamp=0, finger="index", seq=3, normal_force=1.0, torque_z=0.01, temperature=25.0)
    hand.send(whole)
    received = []
    while not received:
        received = node.receive(0.001)
    assert received[0].temperature == 25.0
    assert node.heard == 3


def test_the_more_urgent_of_two_that_send_together_goes_first(bus):
    hand, other, node = (bus.endpoint(codec()) for _ in range(3))
    hand.send(state(1, "index"))
    other.send(state(1, "thumb"))
    first, second = node.receive(0.01), node.receive(0.01)
    assert [first[0].finger, second[0].finger] == ["thumb", "index"]


def test_a_tampering_sender_can_lose_double_and_delay_frames(bus):
    hand, node = bus.endpoint(codec()), bus.endpoint(codec())
    hand.tamper = lambda frame, now: [(now, frame), (now + 5 * MS, frame)]
    hand.send(state(1))
    assert [m.seq for m in node.receive(0.001)] == [1]
    assert node.receive(0.01) == []
    assert (node.heard, node.rejected["counter"]) == (2, 1)
    hand.tamper = lambda *_: []
    hand.send(state(2))
    assert node.receive(0.01) == []
    assert node.heard == 2


def test_what_the_queue_does_not_take_is_counted(bus):
    hand, _ = bus.endpoint(codec()), bus.endpoint(codec())
    for seq in range(1, 101):
        hand.send(state(seq))
    assert hand.rejected["unsent"] == 100 - 64


def test_a_node_that_is_off_is_counted_and_comes_back(bus):
    hand, node = bus.endpoint(codec(), faults=NodeFaults(corruption=1.0)), bus.endpoint(codec())
    hand.send(state(1))
    assert node.receive(0.004) == []
    assert hand.state is ErrorState.OFF
    assert (hand.rejected["bus_off"], hand.rejected["unsent"]) == (1, 1)
    assert bus.errors["bit"] == node.rejected["error_frame"] == 32
    node.receive(0.01)
    assert hand.state is ErrorState.ACTIVE


def test_the_load_is_that_of_the_frames(bus):
    hand, node = bus.endpoint(codec()), bus.endpoint(codec())
    for seq in range(1, 1001):
        hand.send(state(seq))
        node.receive(0.001)
        bus.clock.sleep_until(seq * MS)
    (frame,) = codec().encode(state(1))
    duration = frame_duration(
        BusFrame(frame.arbitration_id, frame.data, fd=True, has_bit_rate_switch=True), BitTiming()
    )
    assert node.bus_load() == pytest.approx(duration / MS, rel=0.05)


def test_a_node_that_leaves_is_forgotten(bus):
    hand, node = bus.endpoint(codec()), bus.endpoint(codec())
    node.close()
    hand.send(state(1))
    bus.clock.sleep_until(10 * MS)
    bus.advance()
    assert hand.state is ErrorState.PASSIVE, "nobody is left to acknowledge"
