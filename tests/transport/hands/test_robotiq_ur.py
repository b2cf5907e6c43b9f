"""Robotiq by the port 63352 of a UR arm: lines of public clients, our driver, and what is no line."""

import socket

import pytest
from drives import PATIENCE, command, press, until

from vegrip.clock import NS
from vegrip.transport.codec import Frame
from vegrip.transport.hands.device_endpoint import virtual_device
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.lines import Line
from vegrip.transport.maps.products import map_of

ENDS = {
    "robotiq-2f85-ur": (20.0, 235.0),
    "robotiq-2f140-ur": (10.0, 125.0),
    "robotiq-hand-e-ur": (20.0, 185.0),
}
NO_LINES = [b"GET XYZ\n", b"SET\n", b"SET POS\n", b"SET POS 256\n", b"SET POS -1\n", b"\xff\n", b"\n"]
# airo-ugent/robotiq2F_tcp robotiq2f/tcp_driver.py at b96d984: _communicate sends a line and takes the answer
# without its last character; johannesWen/pyRobotiqUR pyrobotiqur/robotiq.py at 9617167: SET is told ack
EXCHANGES = [
    (b"GET STA\n", b"STA 0\n"),
    (b"SET ACT 1\n", b"ack"),
    (b"GET STA\n", b"STA 1\n"),
    (b"GET STA\n", b"STA 3\n"),
    (b"SET GTO 1\n", b"ack"),
    (b"SET FOR 100\n", b"ack"),
    (b"SET  POS 100\n", b"ack"),
    (b"GET PRE\n", b"PRE 100\n"),
    (b"GET POS\n", b"POS 100\n"),
    (b"GET OBJ\n", b"OBJ 3\n"),
    (b"GET FLT\n", b"FLT 0\n"),
]


@pytest.fixture
def alone():
    """A device without a line."""
    return virtual_device(open_plan(map_of("robotiq-2f85-ur")))


def test_lines_of_public_clients_are_answered(alone):
    for number, (asked, answered) in enumerate(EXCHANGES, 1):
        now = number * NS // 15  # an activation takes longer than one line, and less than two
        now += 2 * NS if b"POS" in asked else 0
        alone.take_in(Frame(-1, asked, False, now), now)
        assert b"".join(frame.data for frame in alone.due(now)) == answered, asked


@pytest.mark.parametrize("line", NO_LINES)
def test_what_is_no_line_is_not_answered_and_counted(alone, line):
    alone.take_in(Frame(-1, line, False, NS), NS)
    assert alone.due(NS) == []
    assert alone.counts["unknown_request"] == 1


def test_the_driver_sends_one_line_with_all_variables():
    plan = open_plan(map_of("robotiq-2f85-ur"))
    codec = MappedCodec(plan)
    (line,) = (packet.line for packet in plan.database.packets if packet.name == "grip")
    codec.encode(command(235.0))
    (outgoing,) = codec.encoder.wanted()
    said = line.line(outgoing.message(NS)[0].data)
    assert said in {b"SET POS %d SPE 255 FOR 255 GTO 1\n" % place for place in (253, 254, 255)}


@pytest.mark.parametrize(
    ("text", "numbers"),
    [(b"POS 100\n", (100,)), (b"POS  7\r\n", (7,)), (b"POS -3\n", (-3,)), (b"POS x\n", None),
     (b"POS \n", None), (b"POS 1 2\n", None), (b"POS 99999999999\n", None)],
)  # fmt: skip
def test_a_line_is_its_numbers_or_nothing(text, numbers):
    fields = Line("POS {place}").fields(text)
    wanted = None if numbers is None else b"".join(one.to_bytes(4, "big", signed=True) for one in numbers)
    assert fields == wanted


@pytest.mark.parametrize("name", ENDS)
def test_the_driver_activates_presses_and_opens(running, name):
    low, high = ENDS[name]
    drive = running(name)
    with drive.open() as endpoint:
        assert "activated" in endpoint.conditions
        drive.device.jaws.object_at = 50.0
        press(endpoint, high, lambda: drive.presses(high))
        press(endpoint, low, lambda: drive.presses(low))
        until(endpoint, lambda: "holding" in endpoint.conditions)
        press(endpoint, 0.0, lambda: drive.device.forces["jaw"] == 0.0)
        assert not endpoint.rejected


def test_an_object_that_is_lost_is_a_condition(running):
    drive = running("robotiq-2f85-ur")
    with drive.open() as endpoint:
        drive.device.jaws.object_at = 50.0
        endpoint.send(command(60.0, PATIENCE))
        until(endpoint, lambda: "holding" in endpoint.conditions)
        drive.device.jaws.object_at = None
        until(endpoint, lambda: "object_lost" in endpoint.conditions)


def test_an_ack_with_an_end_of_line_is_one_too(running):
    drive = running("robotiq-2f85-ur")
    answered = drive.device.answered

    def ended(data, now):
        size, answer = answered(data, now)
        return size, answer + b"\n" if answer == b"ack" else answer

    drive.device.answered = ended
    with drive.open() as endpoint:
        press(endpoint, 60.0, lambda: drive.presses(60.0))
        assert not endpoint.rejected.keys() & {"resync", "unknown_packet", "unanswered"}


def test_a_lost_connection_is_made_again_and_the_grip_goes_on(running):
    drive = running("robotiq-2f85-ur")
    with drive.open() as endpoint:
        press(endpoint, 60.0, lambda: drive.presses(60.0))
        with socket.create_connection(drive.host):  # takes the place of ours
            until(endpoint, lambda: endpoint.rejected.get("link_lost", 0) > 0)
        press(endpoint, 90.0, lambda: drive.presses(90.0))
        assert drive.device.commanded["ACT"] == 1
