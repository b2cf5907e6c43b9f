"""Laws of the CAN endpoint, over python-can's in-process bus and over a bus that fails."""

import itertools
import math
import time

import can
import pytest

from vegrip.clock import NS
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.transport.can_endpoint import MOST_FRAMES, CanEndpoint
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import CanCodec
from vegrip.transport.open import Hand, open_endpoint

FINGERS = ("thumb", "index")


def codec(fd=True):
    return CanCodec(FINGERS, fd=fd)


def state(seq, force=1.25):
    return FingertipState(stamp=time.monotonic_ns(), finger="index", seq=seq, normal_force=force)


@pytest.fixture
def two():
    """Two endpoints on python-can's own virtual bus."""
    protocol = can.CanProtocol.CAN_FD
    buses = [can.Bus(interface="virtual", channel="endpoint", protocol=protocol) for _ in range(2)]
    endpoints = [CanEndpoint(bus, codec(), timing=BitTiming()) for bus in buses]
    yield endpoints
    for endpoint in endpoints:
        endpoint.close()


def test_messages_go_through_and_bear_the_time_of_arrival(two):
    hand, node = two
    before = time.monotonic_ns()
    hand.send(state(0, force=1.25))
    (got,) = node.receive(1.0)
    assert (got.finger, got.normal_force) == ("index", 1.25)
    assert len(node.arrivals) == 1
    assert before - 2_000_000 <= node.arrivals[0] <= time.monotonic_ns()


@pytest.mark.parametrize("jump", [-86_400.0, -2.0, 0.3, 2.0, 86_400.0])
@pytest.mark.parametrize("interface", ["virtual", "vegrip"])
@pytest.mark.usefixtures("runtime")
def test_a_wall_clock_that_is_set_moves_no_stamp(monkeypatch, interface, jump):
    table = {"interface": interface, "channel": "set"}
    hand, node = (open_endpoint(table, Hand(FINGERS)) for _ in range(2))
    hand.send(state(0))
    assert received_within(node, 2.0)
    wall, wall_ns = time.time, time.time_ns
    monkeypatch.setattr(time, "time", lambda: wall() + jump)
    monkeypatch.setattr(time, "time_ns", lambda: wall_ns() + round(jump * NS))
    for seq in range(1, 4):
        sent = time.monotonic_ns()
        hand.send(state(seq))
        (got,) = received_within(node, 2.0)
        assert sent - NS <= node.arrivals[0] <= time.monotonic_ns(), "within a second the new offset is read"
        assert got.seq == seq
    for endpoint in (hand, node):
        endpoint.close()


def test_everything_that_waits_is_taken_at_once_up_to_a_limit(two):
    hand, node = two
    for seq in range(MOST_FRAMES + 20):
        hand.send(state(seq))
    assert len(node.receive(1.0)) == MOST_FRAMES
    assert len(node.receive(1.0)) == 20
    assert len(node.arrivals) == 20


def test_receive_returns_at_its_time_out_and_at_once_with_zero(two):
    _, node = two
    start = time.monotonic()
    assert node.receive(0.0) == []
    assert time.monotonic() - start < 0.05
    assert node.receive(0.05) == []
    assert 0.05 <= time.monotonic() - start < 1.0


def test_frames_that_mean_nothing_neither_raise_nor_shorten_the_wait(two):
    hand, node = two
    for identifier in (0x7FE, 0x7FF):
        hand._bus.send(can.Message(arbitration_id=identifier, data=b"xyz", is_extended_id=False))
    hand._bus.send(can.Message(arbitration_id=0x123456, data=b"xyz", is_extended_id=True))
    hand._bus.send(can.Message(arbitration_id=0x101, is_remote_frame=True, is_extended_id=False))
    start = time.monotonic()
    assert node.receive(0.1) == []
    assert time.monotonic() - start >= 0.1
    assert node.rejected["unknown_id"] == 2


def test_the_load_is_estimated_from_the_frames_seen(two):
    hand, node = two
    for seq in range(100):
        hand.send(state(seq))
    node.receive(1.0)
    assert 0.0 < node.bus_load() <= 1.0
    assert math.isnan(CanEndpoint(FailingBus(), codec()).bus_load())


class FailingBus(can.BusABC):
    """A bus whose cable has been pulled."""

    def __init__(self, messages=()):
        self.channel_info, self.messages = "failing", list(messages)
        super().__init__("failing")

    def send(self, *_, **__):
        raise can.CanOperationError("no buffer space")

    def _recv_internal(self, *_, **__):
        if self.messages:
            return self.messages.pop(0), False
        raise OSError(100, "Network is down")


def command():
    return ForceCommand(0, "index", 1, 2.0, 0.0, Reason.HOLD, 10**8)


def test_what_the_bus_does_not_take_is_counted_and_never_raised():
    endpoint = CanEndpoint(FailingBus(), codec())
    endpoint.send(command())
    assert endpoint.rejected["unsent"] == 1
    endpoint.close()
    endpoint.send(command())
    assert endpoint.rejected["unsent"] == 2


def test_a_frame_that_may_wait_is_sent_when_there_is_room_again():
    class FullAtFirst(FailingBus):
        full, taken = 5, 0

        def send(self, *_, **__):
            if self.full:
                self.full -= 1
                raise can.CanOperationError("no buffer space")
            self.taken += 1

    bus = FullAtFirst()
    endpoint = CanEndpoint(bus, codec())
    endpoint.patience_s = 60.0
    endpoint.send(command())
    assert (bus.taken, endpoint.rejected) == (1, {})


def test_a_lost_bus_is_counted_waited_for_and_opened_again():
    good = can.Bus(interface="virtual", channel="again", protocol=can.CanProtocol.CAN_FD)
    other = can.Bus(interface="virtual", channel="again", protocol=can.CanProtocol.CAN_FD)
    endpoint = CanEndpoint(FailingBus(), codec(), reopen=lambda: good)
    start = time.monotonic()
    assert endpoint.receive(0.02) == []
    assert endpoint.rejected["bus_lost"] == 1
    assert time.monotonic() - start < 0.5
    endpoint.receive(0.0)
    hand = CanEndpoint(other, codec())
    hand.send(state(0))
    assert len(endpoint.receive(1.0)) == 1
    endpoint.close()
    hand.close()


def test_a_lost_bus_that_stays_lost_is_not_tried_in_every_pass():
    attempts = []

    def refuse():
        attempts.append(1)
        raise OSError(19, "No such device")

    endpoint = CanEndpoint(FailingBus(), codec(), reopen=refuse)
    for _ in range(50):
        assert endpoint.receive(0.0) == []
    assert len(attempts) == 1
    endpoint.close()


def error_frame(kind, data=bytes(8)):
    return can.Message(arbitration_id=kind, is_error_frame=True, data=data, is_extended_id=False)


def test_what_the_controller_reports_is_counted_by_name():
    frames = [error_frame(0x40), error_frame(0x04, bytes([0, 0x10, 0, 0, 0, 0, 0, 0])), error_frame(0x08)]
    endpoint = CanEndpoint(FailingBus(frames), codec())
    endpoint.receive(0.01)
    counted = endpoint.rejected
    assert [counted[name] for name in ("bus_off", "error_passive", "error_frame")] == [1, 1, 1]
    endpoint.close()


@pytest.mark.parametrize(
    ("table", "error", "words"),
    [
        ({"kind": "usb"}, ConfigError, "can, canopen, zmq"),
        ({"chanel": "can0"}, ConfigError, "channel"),
        ({"bitrate": 5}, ConfigError, "bit/s"),
        ({"interface": "nonsense"}, DeviceError, "vegrip and socketcan"),
        ({"interface": "socketcan", "channel": "nope"}, DeviceError, "sudo"),
        ({"kind": "zmq"}, ConfigError, "publish"),
        ({"kind": "zmq", "publish": "tcp://*:5600"}, ConfigError, "curve"),
    ],
)
def test_a_transport_that_cannot_be_opened_says_why_in_one_sentence(table, error, words):
    with pytest.raises(error, match=words) as caught:
        open_endpoint(table, Hand(FINGERS))
    assert "\n" not in str(caught.value)
    assert "Traceback" not in str(caught.value)


@pytest.mark.parametrize("fd", [True, False])
def test_both_layouts_travel_over_the_virtual_bus(runtime, fd):
    table = {"channel": "open", "fd": fd}
    hand, node = open_endpoint(table, Hand(FINGERS)), open_endpoint(table, Hand(FINGERS))
    other = open_endpoint(table, Hand(FINGERS, number=1))
    hand.send(state(3))
    (got,) = node.receive(2.0)
    assert got.normal_force == 1.25
    assert other.receive(0.05) == [], "another hand's frames are not ours"
    assert 0.0 < node.bus_load() < 1.0
    for endpoint in (hand, node, other):
        endpoint.close()


def received_within(endpoint, seconds):
    messages, deadline = [], time.monotonic() + seconds
    while not messages and time.monotonic() < deadline:
        messages = list(endpoint.receive(0.05))
    return messages


@pytest.mark.usefixtures("runtime")
def test_errors_of_the_virtual_bus_are_counted_by_name():
    alone = open_endpoint({"channel": "alone"}, Hand(FINGERS))
    alone.send(state(1))
    assert received_within(alone, 0.1) == []
    assert alone.rejected["error_passive"] == 1
    assert alone.rejected["error_frame"] >= 16
    other = open_endpoint({"channel": "alone"}, Hand(FINGERS))
    assert [message.seq for message in received_within(other, 2.0)] == [1]
    for endpoint in (alone, other):
        endpoint.close()


@pytest.mark.usefixtures("runtime")
def test_the_time_of_a_state_is_that_of_its_sample_whatever_the_clock_of_the_hand():
    table = {"channel": "clocks"}
    hand = open_endpoint(table, Hand(FINGERS))
    node = open_endpoint({**table, "estimate_clock": True, "order_window": 0.01}, Hand(FINGERS))
    for seq in range(1, 6):
        hand.send(FingertipState(stamp=seq * 100_000, finger="index", seq=seq, normal_force=1.0))
    got = []
    while len(got) < 5:
        got += received_within(node, 2.0)
    # The bus takes longer than 0.1 ms for each, so their arrivals lie further apart than their samples did.
    assert [b.stamp - a.stamp for a, b in itertools.pairwise(got)] == [100_000] * 4
    assert all(message.stamp <= time.monotonic_ns() for message in got)
    assert node.clock.jitter > 0.0
    assert hand.clock is None
    assert "clock_jump" not in node.rejected
    hand.send(FingertipState(stamp=3600 * NS, finger="index", seq=6, normal_force=1.0))
    assert received_within(node, 2.0)
    assert node.rejected["clock_jump"] == 1
    for endpoint in (hand, node):
        endpoint.close()
