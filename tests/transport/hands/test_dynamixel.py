"""Dynamixel X: its maker's client at our device, our driver's bytes against that client's, and faults."""

import struct
from functools import partial

import pytest
from drives import PATIENCE, command, press, until

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.transport.codec import Frame
from vegrip.transport.hands.device_endpoint import virtual_device
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.checksums import appended
from vegrip.transport.maps.products import map_of, virtual_text


@pytest.fixture
def path(tmp_path):
    """The map with the gain of the virtual device."""
    path = tmp_path / "x.toml"
    path.write_text(virtual_text(map_of("dynamixel-x")))
    return path


@pytest.fixture
def motor(running):
    return running("dynamixel-x")


class Tap:
    """A port of the maker's client that keeps what is written."""

    is_using = False

    def __init__(self):
        self.written = b""

    def clearPort(self):  # noqa: N802 (its name)
        pass

    def setPacketTimeout(self, length):  # noqa: N802
        pass

    def writePort(self, packet):  # noqa: N802
        self.written += bytes(packet)
        return len(packet)


def theirs(call, *arguments):
    handler = pytest.importorskip("dynamixel_sdk").Protocol2PacketHandler()
    tap = Tap()
    getattr(handler, call)(tap, 1, *arguments)
    return tap.written


def asked(device, data, now=NS):
    device.take_in(Frame(-1, data, False, now), now)
    return b"".join(frame.data for frame in device.due(now))


def test_the_checksum_is_that_of_the_maker_s_client():
    handler = pytest.importorskip("dynamixel_sdk").Protocol2PacketHandler()
    for size in (1, 2, 9, 30, 100):
        data = bytes((11 * number + size) & 0xFF for number in range(size))
        assert appended("dynamixel", data)[-2:] == handler.updateCRC(0, list(data), size).to_bytes(
            2, "little"
        )


def test_all_that_the_driver_says_is_what_the_maker_s_client_would_say(path):
    plan = open_plan(path)
    said = [*plan.hand.device.opening, *plan.hand.device.poll]
    sent = [appended("dynamixel", bytes.fromhex(one["data"])) for one in said]
    reads = {(11, 1), (64, 7), (126, 2), (132, 4)}
    known = [theirs("readTx", *one) for one in reads]
    known += [theirs("write1ByteTxOnly", *one) for one in ((64, 0), (11, 5), (64, 1))]
    assert set(sent) == set(known)
    codec = MappedCodec(plan)
    for force, current in ((0.0, 0), (1.0, 30), (20.0, 600), (99.0, 1193)):
        codec.encode(command(force))
        (outgoing,) = codec.encoder.wanted()
        body = struct.pack("<HiIIi", current, 0, 0, 0, 2800 if force else 1024)
        assert outgoing.message(NS)[0].data == theirs("writeTxOnly", 102, len(body), list(body))


def test_the_maker_s_client_reads_writes_and_is_refused_by_our_device(motor):
    sdk = pytest.importorskip("dynamixel_sdk")
    port, client = sdk.PortHandler(motor.port.address), sdk.PacketHandler(2.0)
    assert port.openPort()
    assert port.setBaudRate(57600)
    client_patience = 1000.0 * PATIENCE
    port.setPacketTimeout = lambda length: port.setPacketTimeoutMillis(client_patience)  # noqa: ARG005
    assert client.ping(port, 1) == (1020, sdk.COMM_SUCCESS, 0)
    assert client.write1ByteTxRx(port, 1, 11, 5) == (sdk.COMM_SUCCESS, 0)
    assert client.write1ByteTxRx(port, 1, 64, 1) == (sdk.COMM_SUCCESS, 0)
    assert client.write1ByteTxRx(port, 1, 11, 3) == (sdk.COMM_SUCCESS, 7)  # locked while torque is on
    assert client.write2ByteTxRx(port, 1, 102, 300) == (sdk.COMM_SUCCESS, 0)
    assert client.write4ByteTxRx(port, 1, 116, 2800) == (sdk.COMM_SUCCESS, 0)
    assert motor.device.forces["jaw"] == 10.0
    assert client.read4ByteTxRx(port, 1, 116) == (2800, sdk.COMM_SUCCESS, 0)
    stuffed = 0x00FDFFFF  # FF FF FD 00 on the wire
    assert client.write4ByteTxRx(port, 1, 104, stuffed) == (sdk.COMM_SUCCESS, 0)
    assert client.read4ByteTxRx(port, 1, 104) == (stuffed, sdk.COMM_SUCCESS, 0)
    port.closePort()


def test_damage_strangers_and_the_unknown_are_answered_as_the_protocol_says(path):
    device = virtual_device(open_plan(path))
    ping = appended("dynamixel", bytes.fromhex("FFFFFD00 01 0300 01"))
    assert asked(device, ping)[8:10] == b"\x00\xfc"
    assert asked(device, ping[:-1] + b"\0")[8] == 3
    assert asked(device, appended("dynamixel", bytes.fromhex("FFFFFD00 02 0300 01"))) == b""
    assert asked(device, appended("dynamixel", bytes.fromhex("FFFFFD00 01 0300 77")))[8] == 2
    assert asked(device, appended("dynamixel", bytes.fromhex("FFFFFD00 01 0700 02 F000 0400")))[8] == 5
    assert asked(device, b"noise" + ping)[8] == 0
    assert device.counts["unknown_request"] == 5


def test_the_driver_sets_the_mode_presses_and_opens(motor):
    with motor.open() as endpoint:
        assert endpoint.conditions == {"right_mode", "ready"}
        assert motor.device.table[11] == 5
        motor.device.jaws.object_at = 100.0
        for force in (1.0, 20.0, 5.0):
            press(endpoint, force, partial(motor.presses, force))
        press(endpoint, 0.0, lambda: motor.device.forces["jaw"] == 0.0)
        assert not endpoint.rejected


def test_a_motor_that_has_torque_in_its_mode_is_left_alone(motor):
    with motor.open():
        pass
    written = []
    write = motor.device._write
    motor.device._write = lambda at, data: (written.append(at), write(at, data))[1]
    with motor.open():
        pass
    assert written == []


def test_a_shutdown_of_the_motor_is_told_and_torque_is_not_given_again(motor):
    with motor.open() as endpoint:
        press(endpoint, 20.0, lambda: motor.presses(20.0))
        motor.device.table[70] = 0x20  # overload: the motor switches its torque off
        motor.device.table[64] = 0
        until(endpoint, lambda: {"overload", "torque_lost"} <= endpoint.conditions)
        assert endpoint.rejected["overload"] == endpoint.rejected["torque_lost"] == 1
        assert motor.device.table[64] == 0


def test_a_refused_command_is_counted(motor):
    with motor.open() as endpoint:
        motor.device._obey = lambda *_: motor.device._status(4)
        endpoint.send(command(20.0, PATIENCE))
        until(endpoint, lambda: endpoint.rejected.get("command_refused", 0) > 0)


def test_without_the_measured_gain_it_is_refused_with_how_to_measure():
    with pytest.raises(ConfigError, match="gain of command is not known: write closed and opened first"):
        open_plan(map_of("dynamixel-x"))
