"""Weiss WSG 50: bytes of public clients, our driver at our device, refusals and faults."""

import struct

import pytest
from drives import PATIENCE, command, press, until

from vegrip.clock import NS
from vegrip.errors import DeviceError
from vegrip.transport.codec import Frame
from vegrip.transport.hands.device_endpoint import virtual_device
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.checksums import weiss_crc
from vegrip.transport.maps.products import map_of

PUBLIC = bytes.fromhex("AAAAAA 20 0100 00 8F83")  # of a public client of the same maker's tactile sensor
TABLE = [0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50A5, 0x60C6, 0x70E7, 0x8108, 0x9129, 0xA14A]
"""The first entries of CRC_TABLE in ipa320/ipa325_wsg50 src/WSG50Communicator.cpp at 24d7e95."""


def checksum(data):
    """Its checksum_update_crc16, with the table by long division of each bit."""
    value = 0xFFFF
    for byte in data:
        entry = ((value ^ byte) & 0xFF) << 8
        for _ in range(8):
            entry = entry << 1 ^ (0x1021 if entry & 0x8000 else 0)
        value = entry & 0xFFFF ^ value >> 8
    return value


def message(what, payload=b""):
    """Its msg_build."""
    body = b"\xaa\xaa\xaa" + struct.pack("<BH", what, len(payload)) + payload
    return body + struct.pack("<H", checksum(body))


@pytest.fixture
def alone():
    """A device without a line, at home."""
    device = virtual_device(open_plan(map_of("weiss-wsg50")))
    asked(device, message(0x20, b"\0"))
    return device


@pytest.fixture
def wsg(running):
    return running("weiss-wsg50")


def asked(device, data, now=NS):
    device.take_in(Frame(-1, data, False, now), now)
    return b"".join(frame.data for frame in device.due(now))


def test_the_checksum_is_that_of_public_clients():
    assert weiss_crc(PUBLIC[:-2]).to_bytes(2, "little") == PUBLIC[-2:]
    assert message(0x20, b"\0") == PUBLIC
    assert [weiss_crc([byte ^ 0xFF]) ^ 0xFF for byte in range(11)] == TABLE


@pytest.mark.parametrize("size", [0, 1, 2, 7, 64, 255])
def test_the_checksum_is_that_of_the_sample_code_for_any_bytes(size):
    data = bytes((7 * number + size) & 0xFF for number in range(size))
    assert weiss_crc(data) == checksum(data)


def test_all_that_the_driver_says_has_the_form_of_a_public_client():
    plan = open_plan(map_of("weiss-wsg50"))
    codec = MappedCodec(plan)
    codec.encode(command(42.5))
    (outgoing,) = codec.encoder.wanted()
    assert outgoing.message(NS)[0].data == message(0x32, struct.pack("<f", 42.5))
    device = virtual_device(plan)
    told = plan.hand.device
    limit = plan.hand.packets["limit"]
    for entry in (*told.opening, *told.poll, *told.closing, *limit.then, *limit.opened):
        body = bytes.fromhex(entry["data"])
        answer = asked(device, message(body[3], body[6:]))
        assert body == message(body[3], body[6:])[:-2]
        assert answer[3] == body[3]
        assert struct.unpack_from("<H", answer, 6)[0] in (0, 26)
    assert not device.counts


def test_a_damaged_unknown_or_misshapen_message_is_answered_by_its_error(alone):
    damaged = bytearray(message(0x41, bytes(3)))
    damaged[7] ^= 1
    assert struct.unpack_from("<H", asked(alone, bytes(damaged)), 6) == (11,)
    assert struct.unpack_from("<H", asked(alone, message(0x77)), 6) == (14,)
    assert struct.unpack_from("<H", asked(alone, message(0x32, b"1234567")), 6) == (15,)
    assert struct.unpack_from("<H", asked(alone, message(0x32, struct.pack("<f", 81.0))), 6) == (28,)
    assert asked(alone, message(0x41, bytes(3))[:5]) == b""
    assert asked(alone, message(0x41, bytes(3))[5:])[3] == 0x41


def test_a_limit_alone_does_not_change_the_grip_of_our_device(alone):
    asked(alone, message(0x32, struct.pack("<f", 20.0)))
    asked(alone, message(0x25, struct.pack("<2f", 0.0, 80.0)))
    assert alone.forces["jaw"] == 20.0
    asked(alone, message(0x32, struct.pack("<f", 60.0)))
    assert alone.forces["jaw"] == 20.0


def test_the_driver_goes_home_presses_and_opens(wsg):
    with wsg.open() as endpoint:
        assert {"ready", "referenced", "free"} <= endpoint.conditions
        wsg.device.jaws.object_at = 1.0
        for force in (20.0, 80.0, 5.0):
            press(endpoint, force, lambda force=force: wsg.presses(force))
        until(endpoint, lambda: "holding" in endpoint.conditions)
        press(endpoint, 0.0, lambda: wsg.device.forces["jaw"] == 0.0)
        assert not endpoint.rejected
        press(endpoint, 90.0, lambda: wsg.presses(80.0))
        assert endpoint.rejected["clipped"] > 0


def test_a_grip_is_said_once_for_each_force(wsg):
    grips = []
    move = wsg.device._move
    wsg.device._move = lambda what, payload: (grips.append(what), move(what, payload))[1]
    with wsg.open() as endpoint:
        press(endpoint, 20.0, lambda: wsg.presses(20.0))
        polls = [0]
        obey = wsg.device._obey

        def counted(what, payload):
            polls[0] += what == 0x32
            return obey(what, payload)

        wsg.device._obey = counted
        until(endpoint, lambda: polls[0] >= 3)  # the limit is said again and again
    assert grips == [0x25]


def test_a_fast_stop_is_acknowledged_when_it_is_opened_and_not_by_itself(wsg):
    wsg.device.is_referenced = wsg.device.is_stopped = True
    with wsg.open() as endpoint:
        assert not wsg.device.is_stopped
        wsg.device.is_stopped = True
        until(endpoint, lambda: "stopped" in endpoint.conditions)
        endpoint.send(command(20.0, PATIENCE))
        until(endpoint, lambda: endpoint.rejected.get("stopped", 0) == 2)  # also when it was opened
        assert wsg.device.is_stopped


def test_a_connection_that_was_lost_is_a_fast_stop_that_ends_by_itself_and_the_force_is_said_again(wsg):
    with wsg.open() as endpoint:
        press(endpoint, 20.0, lambda: wsg.presses(20.0))
        wsg.device.is_stopped, wsg.device.forces["jaw"] = True, 0.0
        wsg.device._grips_with = 0.0
        wsg.port._drop()
        until(endpoint, lambda: endpoint.rejected.get("link_lost"))
        press(endpoint, 20.0, lambda: wsg.presses(20.0))
        assert endpoint.obeys
        assert "not_ready" not in endpoint.rejected  # nobody has to start the node again


def test_a_device_that_is_at_home_is_not_sent_home(wsg):
    wsg.device.is_referenced = True
    homed = []
    obey = wsg.device._obey
    wsg.device._obey = lambda what, payload: (homed.append(what), obey(what, payload))[1]
    with wsg.open():
        pass
    assert 0x20 not in homed


def test_lost_part_and_no_part_are_conditions(wsg):
    with wsg.open() as endpoint:
        wsg.device.jaws.object_at = 1.0
        press(endpoint, 20.0, lambda: "holding" in endpoint.conditions)
        wsg.device.jaws.object_at = None
        assert endpoint.device_faults == set()  # to hold is none
        until(endpoint, lambda: "object_lost" in endpoint.conditions)
        assert {name for _, name in endpoint.device_faults} == {"object_lost"}
        press(endpoint, 30.0, lambda: "at_its_end" in endpoint.conditions)
        assert {name for _, name in endpoint.device_faults} == {"at_its_end"}
        assert (endpoint.rejected["object_lost"], endpoint.rejected["at_its_end"]) == (1, 1)


def test_a_refused_force_is_counted(wsg):
    with wsg.open() as endpoint:
        wsg.device.limits = type(wsg.device.limits)(minimum=5.0, maximum=10.0)
        endpoint.send(command(20.0, PATIENCE))
        until(endpoint, lambda: endpoint.rejected.get("force_refused", 0) > 0)


ALREADY_RUNNING = struct.pack("<H", 4)
"""E_ALREADY_RUNNING of its command set: a grip while the jaws still move."""


def test_a_grip_or_release_that_is_refused_is_counted_and_said_again(wsg):
    move, refusals = wsg.device._move, []

    def refuses(what, payload):
        if what in refusals:
            return move(what, payload)
        refusals.append(what)
        return message(what, ALREADY_RUNNING)

    wsg.device._move = refuses
    with wsg.open() as endpoint:
        wsg.device.jaws.object_at = 1.0
        press(endpoint, 20.0, lambda: "grip_refused" in endpoint.conditions)
        assert not endpoint.obeys  # it presses with what it pressed before
        until(endpoint, lambda: wsg.presses(20.0) and endpoint.obeys)
        press(endpoint, 0.0, lambda: wsg.presses(0.0) and endpoint.obeys)
        assert (endpoint.rejected["grip_refused"], endpoint.rejected["release_refused"]) == (1, 1)


def test_a_device_that_does_not_come_home_is_refused_with_what_it_says(wsg):
    wsg.path.write_text(wsg.path.read_text().replace("patience = 18.0", "patience = 0.5"))
    obey = wsg.device._obey
    wsg.device._obey = lambda what, payload: b"" if what == 0x20 else obey(what, payload)
    with pytest.raises(DeviceError, match=r"is not 'ready' within 0.5 s; it says of itself: free"):
        wsg.open()
