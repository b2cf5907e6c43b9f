"""The worked maps against simulated devices that speak these protocols, packed from their documents."""

import math
import struct
import time
from pathlib import Path

import can
import pytest

from vegrip.clock import NS
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec import Frame
from vegrip.transport.hands.endpoints import MappedCanEndpoint
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import price

HANDS = Path(__file__).parents[3] / "examples" / "hands"
MS = 1_000_000


def command(force, finger, stamp):
    return ForceCommand(stamp, finger, 0, force, 0.0, Reason.HOLD, stamp + 100 * MS)


class MsgGripper:
    """Answers command 61 by 60: position, current [mA], eight bits, the first the highest."""

    def __init__(self):
        self.position, self.limit, self.active = 100, 0, False

    def hear(self, identifier, data):
        assert identifier == 61 << 1
        if data:
            self.position, _, self.limit, bits = struct.unpack(">BBhB", data)
            self.active = bits >> 6 == 0b11
        return 60 << 1, struct.pack(">BhB", self.position, self.limit, 0b1100_0001 if self.active else 1)


def test_the_msg_gripper_is_polled_grips_by_its_current_and_holds_when_commands_stop():
    codec = MappedCodec(open_plan(HANDS / "msg_gripper.toml"))
    gripper = MsgGripper()
    (ask,) = codec.due(0)
    assert ask.data == b""
    identifier, data = gripper.hear(ask.arbitration_id, ask.data)
    (state,) = codec.decode_all(Frame(identifier, data, False, 1))
    assert state.displacement == pytest.approx(0.0, abs=1e-9)
    assert (state.tangential_force_x, state.tangential_force_y) == (2.0, 0.0)
    (frame,) = codec.encode(command(10.0, "jaw", 20 * MS))
    identifier, data = gripper.hear(frame.arbitration_id, frame.data)
    assert (gripper.limit, gripper.position, gripper.active) == (400, 255, True)
    (state,) = codec.decode_all(Frame(identifier, data, False, 21 * MS))
    assert state.normal_force == pytest.approx(0.4 * 25)
    for force, limit in ((1.0, 150), (100.0, 1000)):  # never outside what its document allows
        (frame,) = codec.encode(command(force, "jaw", 40 * MS))
        gripper.hear(frame.arbitration_id, frame.data)
        assert gripper.limit == limit
    assert gripper.hear(*codec.due(90 * MS)[0][:2])
    assert gripper.limit == 1000  # repeated
    late = codec.due(2 * NS)
    assert [frame.data for frame in late] == [b""]  # it holds by itself: only asked from now on
    told = " ".join(price(codec.plan))
    assert "currents" in told
    assert "stated as 2 N" in told
    assert "50 Hz" in told


def allegro_tip(finger, tip, stamp):
    return Frame(0x54 + finger, struct.pack(">hhhh", 0, 0, 0, round(10 * tip)), False, stamp)


def allegro_pose(finger, degrees, stamp):
    return Frame(
        0x20 + finger, struct.pack("<hhhh", *(round(angle / 0.088) for angle in degrees)), False, stamp
    )


def test_the_allegro_hand_presses_by_joint_torques_and_feels_by_its_tips():
    plan = open_plan(HANDS / "allegro_v5_sense.toml")
    codec = MappedCodec(plan)
    assert [frame[:2] for frame in codec.due(0)] == [(0x81, bytes.fromhex("030000000000")), (0x40, b"")]
    codec.decode_all(allegro_pose(3, (0.0, 1.0, 0.5, 0.2), 1))  # the thumb is the fourth there
    (state,) = codec.decode_all(allegro_tip(0, 250.0, 2 * MS))  # and the first here
    assert state.finger == "thumb"
    assert state.normal_force == pytest.approx(2.5)
    angle = sum(w * round(a / 0.088) * 0.088 for w, a in ((1.0, 1.0), (0.62, 0.5), (0.29, 0.2)))
    assert state.displacement == pytest.approx(0.096 * math.radians(angle))
    (frame,) = codec.encode(command(2.0, "thumb", 3 * MS))
    assert frame.arbitration_id == 0x63
    joints = struct.unpack("<hhhh", frame.data)
    assert joints == (0, 137, 170, 80)  # 68.6 * 2, and the shares of the two joints behind it
    (frame,) = codec.encode(command(60.0, "thumb", 4 * MS))
    assert max(struct.unpack("<hhhh", frame.data)) <= 240
    assert codec.clipped == {"thumb": 1}
    assert "it OPENS when they stop" in " ".join(price(plan))
    repeated = [f for n in range(1, 200) for f in codec.due(4 * MS + n * 3 * MS)]
    assert len(repeated) == 199  # never silent, never zero: without commands it would open
    assert all(struct.unpack("<hhhh", frame.data)[1] == 190 for frame in repeated)


@pytest.fixture
def bus():
    device = can.Bus(interface="virtual", channel="published")
    endpoint = MappedCanEndpoint(
        can.Bus(interface="virtual", channel="published"),
        MappedCodec(open_plan(HANDS / "msg_gripper.toml")),
    )
    yield device, endpoint
    endpoint.close()
    device.shutdown()


def test_over_a_bus_the_endpoint_polls_and_tells_when_nothing_comes(bus, monkeypatch):
    device, endpoint = bus
    gripper = MsgGripper()
    endpoint.receive(0.0)
    asked = device.recv(1.0)
    identifier, data = gripper.hear(asked.arbitration_id, bytes(asked.data))
    device.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
    (state,) = endpoint.receive(1.0)
    assert state.finger == "jaw"
    assert len(endpoint.arrivals) == 1
    assert "no_traffic" not in endpoint.rejected


def test_a_bus_without_the_hand_is_told_after_two_seconds(bus, monkeypatch):
    device, endpoint = bus
    device.send(can.Message(arbitration_id=0x321, data=b"\x00", is_extended_id=False))
    endpoint.receive(0.1)
    now = time.monotonic_ns()
    monkeypatch.setattr(time, "monotonic_ns", lambda: now + 3 * NS)
    assert endpoint.rejected["no_traffic"] == 1
    assert endpoint.rejected["foreign"] == 1
