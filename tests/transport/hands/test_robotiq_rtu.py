"""Robotiq over Modbus RTU: the maker's bytes, public clients at our device, our driver at it, and faults."""

import itertools
import os
import pty
import re
import threading
import time
import tty
from functools import partial

import pytest
from drives import PATIENCE, command, press, until

from vegrip.clock import NS
from vegrip.config import read_toml
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import ForceCommand, Reason
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.byte_link import remedy
from vegrip.transport.codec import Frame
from vegrip.transport.hands import link_endpoint
from vegrip.transport.hands.device_endpoint import virtual_device
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.map_text import whole
from vegrip.transport.maps.products import map_of
from vegrip.transport.open import Hand, open_endpoint

MODELS = {"robotiq-2f85": (20.0, 235.0), "robotiq-2f140": (10.0, 125.0), "robotiq-hand-e": (20.0, 185.0)}
# instruction manual 2F-85 and 2F-140, 4.7.2: requests and the answers to them
CLOSE = bytes.fromhex("09 10 03E8 0003 06 0900 00FF FFFF 42 29")
OPEN = bytes.fromhex("09 10 03E8 0003 06 0900 0000 FFFF 72 19")
WRITTEN = bytes.fromhex("09 10 03E8 0003 01 30")
CLEAR = bytes.fromhex("09 10 03E8 0003 06 0000 0000 0000 73 30")
READ_ONE = bytes.fromhex("09 03 07D0 0001 85 CF")


@pytest.fixture(params=MODELS)
def drive(request, running):
    return running(request.param)


@pytest.fixture
def small(running):
    return running("robotiq-2f85")


def asked(device, data, now=NS):
    device.take_in(Frame(-1, data, False, now), now)
    return b"".join(frame.data for frame in device.due(now))


@pytest.fixture
def alone():
    """A device without a line."""
    return virtual_device(open_plan(map_of("robotiq-2f85")))


def test_our_device_answers_the_manual_s_requests_with_its_bytes(alone):
    assert [asked(alone, one) for one in (CLEAR, CLOSE, OPEN)] == [WRITTEN] * 3
    assert asked(alone, READ_ONE)[:3] == bytes.fromhex("09 03 02")


def test_our_driver_closes_with_the_manual_s_bytes():
    codec = MappedCodec(open_plan(map_of("robotiq-2f85")))
    made = sent(codec, (100.0, 50.0, 235.0, 0.0))
    assert made[2] == CLOSE  # on the turn of 255
    assert made[-1][7:-2] == OPEN[7:-4] + b"\xff\x00"  # opens, with the least force


@pytest.mark.parametrize("name", MODELS)
def test_least_and_largest_force_are_the_ends_of_the_register(name):
    plan = open_plan(map_of(name))
    low, high = MODELS[name]
    assert (plan.hand.drive.minimum, plan.hand.drive.maximum) == (low, high)
    codec = MappedCodec(plan)
    raws = [data[12] for data in sent(codec, (low, high, (low + high) / 2))]
    assert raws[:2] == [0, 255]
    assert raws[2] in (127, 128)
    assert not codec.clipped
    assert sent(codec, [low - 5.0])[0][12] == 0  # it can press no less, which is counted
    assert codec.clipped["jaw"] == 1


def sent(codec, forces):
    """Return the bytes of each force, made when it is its turn on the line."""
    found = []
    for force in forces:
        codec.encode(command(force))
        (outgoing,) = codec.encoder.wanted()
        found.append(outgoing.message(time.monotonic_ns())[0].data)
    return found


def test_a_command_whose_time_is_over_is_repeated_and_counted_once_it_was_sent(tmp_path):
    """To a hand of which is not known what it does when commands stop."""
    (tmp_path / "own.toml").write_text('like = "robotiq-2f85"\n[command]\nsilence = "unknown"\n')
    codec = MappedCodec(open_plan(tmp_path / "own.toml"))
    codec.encode(ForceCommand(0, "jaw", 0, 30.0, 0.0, Reason.HOLD, NS))
    (outgoing,) = codec.encoder.wanted()
    codec.encoder.due(2 * NS)
    assert codec.encoder.held == 0
    outgoing.message(3 * NS)
    for late in (4, 5):
        outgoing.is_wanted = False
        assert codec.encoder.due(late * NS) == []
        assert codec.encoder.wanted() == [outgoing]
    assert codec.encoder.held == 2


def test_each_new_force_goes_with_a_new_motion_and_the_same_force_without():
    codec = MappedCodec(open_plan(map_of("robotiq-2f85")))
    forces = (30.0, 40.0, 40.0, 40.0, 50.0, 50.2, 30.0)
    places = [data[10] for data in sent(codec, forces)]
    assert all(place in (253, 254, 255) for place in places)
    turns = [a != b for a, b in itertools.pairwise(places)]
    assert turns == [True, False, False, True, False, True]


def test_a_force_without_a_motion_does_nothing_to_our_device(alone):
    """So that a driver that only rewrites the force is found out."""
    asked(alone, CLEAR)
    asked(alone, bytes.fromhex("09 10 03E8 0001 02 0100 E4 28"))
    alone.go(2 * NS)
    asked(alone, CLOSE, 2 * NS)
    assert alone.forces["jaw"] == 235.0
    codec = MappedCodec(open_plan(map_of("robotiq-2f85")))
    softer = next(data for data in sent(codec, (100.0, 110.0, 120.0)) if data[10] == CLOSE[10])
    asked(alone, softer, 3 * NS)
    assert alone.forces["jaw"] == 235.0


def test_pyrobotiqgripper_activates_closes_and_finds_an_object(small):
    client = pytest.importorskip("pyrobotiqgripper").RobotiqGripper(small.port.address)
    client.activate()
    assert client.isActivated()
    client.close()
    assert client.position() == 255
    client.open()
    assert client.position() == 0
    small.device.jaws.object_at = 120.0
    client.close(force=100)
    assert (client.position(), client.objectDetection()) == (120, 2)
    assert small.device.forces["jaw"] == pytest.approx(20.0 + 215.0 * 100 / 255)
    client.disconnect()


def test_minimalmodbus_reads_writes_and_is_refused(small):
    minimalmodbus = pytest.importorskip("minimalmodbus")
    client = minimalmodbus.Instrument(small.port.address, 9)
    client.serial.baudrate, client.serial.timeout = 115_200, PATIENCE
    client.write_registers(0x03E8, [0x0100])
    end = time.monotonic() + PATIENCE
    while client.read_registers(0x07D0, 3)[0] >> 12 & 3 != 3:
        assert time.monotonic() < end
    client.write_register(0x03EA, 0xFF40, functioncode=6)
    assert client.read_registers(0x03E8, 3) == [0x0100, 0, 0xFF40]
    client.serial.timeout = 2.0  # [s] it waits so long for the rest of what a refusal is shorter by
    with pytest.raises(minimalmodbus.IllegalRequestError):
        client.read_registers(0x0100, 3)
    client.serial.close()


def test_what_we_send_is_what_minimalmodbus_makes_of_the_same_registers():
    minimalmodbus = pytest.importorskip("minimalmodbus")
    crc = minimalmodbus._calculate_crc
    codec = MappedCodec(open_plan(map_of("robotiq-2f85")))
    plan = codec.plan
    told = [bytes.fromhex(one["data"]) for one in (*plan.hand.device.opening, *plan.hand.device.poll)]
    for data in told + sent(codec, map(float, range(20, 236))):
        theirs = crc(data[:-2])
        theirs = theirs if isinstance(theirs, bytes) else theirs.encode("latin-1")
        assert data[-2:] == theirs


def test_the_driver_activates_presses_and_opens(drive):
    low, high = MODELS[drive.path.stem]
    with drive.open() as endpoint:
        assert "activated" in endpoint.conditions
        drive.device.jaws.object_at = 50.0
        for force in (low, (low + high) / 2, high, low):
            press(endpoint, force, partial(drive.presses, force))
        until(endpoint, lambda: "holding" in endpoint.conditions)
        press(endpoint, 0.0, lambda: drive.device.forces["jaw"] == 0.0)
        assert not endpoint.rejected


def test_an_activated_gripper_is_not_activated_again(small):
    with small.open():
        pass
    told = []
    tell = small.device.tell
    small.device.tell = lambda values, now: (told.append(values), tell(values, now))
    with small.open() as endpoint:
        assert "activated" in endpoint.conditions
    assert told == []


def test_an_object_that_is_lost_is_counted_once_and_told(small):
    with small.open() as endpoint:
        small.device.jaws.object_at = 50.0
        endpoint.send(command(60.0, PATIENCE))
        until(endpoint, lambda: "holding" in endpoint.conditions)
        small.device.jaws.object_at = None
        until(endpoint, lambda: "object_lost" in endpoint.conditions)
        assert endpoint.rejected["object_lost"] == endpoint.rejected["at_its_end"] == 1
        press(endpoint, 0.0, lambda: "object_lost" not in endpoint.conditions)
        assert endpoint.rejected["object_lost"] == 1


def test_closed_on_nothing_is_at_its_end_and_nothing_lost(small):
    with small.open() as endpoint:
        press(endpoint, 60.0, lambda: "at_its_end" in endpoint.conditions)
        assert "object_lost" not in endpoint.rejected


@pytest.mark.parametrize(
    ("fault", "name"),
    [(5, "not_activated"), (8, "too_hot"), (9, "was_alone"), (10, "low_voltage"), (12, "internal_fault"),
     (13, "activation_failed"), (14, "overcurrent"), (15, "released")],
)  # fmt: skip
def test_a_fault_is_a_condition_and_a_count_never_an_exception(small, fault, name):
    with small.open() as endpoint:
        small.device.fault = fault
        until(endpoint, lambda: name in endpoint.conditions)
        small.device.fault = 0
        until(endpoint, lambda: name not in endpoint.conditions)
        assert endpoint.rejected[name] == 1


def test_a_gripper_that_loses_its_activation_is_not_moved_by_itself(small, monkeypatch):
    monkeypatch.setattr(link_endpoint, "REOPEN_PERIOD", NS // 100)
    with small.open() as endpoint:
        press(endpoint, 60.0, lambda: small.device.forces.get("jaw", 0.0) > 50.0)
        assert endpoint.obeys
        small.device.commanded = dict.fromkeys(small.device.commanded, 0)
        until(endpoint, lambda: "activation_lost" in endpoint.conditions)
        assert not endpoint.obeys
        for force in (60.0, 80.0, 100.0):  # a command says "activated", too, which would open and close it
            end = time.monotonic() + 0.15
            press(endpoint, force, partial(lambda end: time.monotonic() > end, end))
        assert endpoint.rejected["activation_lost"] == 1
        assert endpoint.rejected["not_ready"] > 0
        assert "is no longer 'activated': it is sent no command" in endpoint.hints["not_ready"]
        assert small.device.commanded["ACT"] == 0
        small.device.commanded["ACT"] = 1  # by its owner
        press(endpoint, 120.0, lambda: small.presses(120.0))


def test_what_was_silent_says_that_it_is_ready_before_it_is_commanded_anything(small):
    with small.open() as endpoint:
        press(endpoint, 60.0, lambda: small.presses(60.0))
        answered = small.device.answered
        small.device.answered = lambda data, now: (len(data), b"")  # noqa: ARG005 (switched off)
        until(endpoint, lambda: endpoint.rejected.get("unanswered", 0) > 2)
        small.device.commanded, small.device.answered = dict.fromkeys(small.device.commanded, 0), answered
        endpoint.send(command(80.0, PATIENCE))
        until(endpoint, lambda: "activation_lost" in endpoint.conditions)
        press(endpoint, 90.0, lambda: endpoint.rejected.get("not_ready", 0) > 0)  # its opening waits, too
        assert small.device.commanded["ACT"] == 0


def test_an_exception_of_the_device_is_counted(small):
    with small.open() as endpoint:
        small.device._write = lambda *_: False
        endpoint.send(command(60.0))
        until(endpoint, lambda: endpoint.rejected.get("modbus_exception", 0) > 0)


def test_commands_and_polls_take_turns_and_only_the_newest_command_is_sent(small):
    with small.open() as endpoint:
        heard = []
        answered = small.device.answered

        def listen(data, now):
            heard.append(bytes(data))
            return answered(data, now)

        small.device.answered = listen
        for force in range(21, 200):
            endpoint.send(command(float(force), PATIENCE))
        until(endpoint, partial(small.presses, 199.0))
        assert all(len(one) in (8, 15) for one in heard)  # never two requests at once
        assert sum(len(one) == 15 for one in heard) < 60
        assert "unanswered" not in endpoint.rejected


def test_another_device_is_refused_in_one_sentence(tmp_path):
    ours, other = pty.openpty()
    tty.setraw(ours)
    tty.setraw(other)
    stops = threading.Event()

    def chatter():
        while not stops.is_set():
            os.write(ours, b"$GPGGA,,,,,,0\r\n")
            stops.wait(0.01)

    talker = threading.Thread(target=chatter)
    talker.start()
    text = map_of("robotiq-2f85").read_text().replace("patience = 12.0", "patience = 0.3")
    path = tmp_path / "mine.toml"
    path.write_text(text)
    try:
        with pytest.raises(DeviceError) as refused:
            open_endpoint("serial", Hand(("jaw",)), map=str(path), address=os.ttyname(other))
    finally:
        stops.set()
        talker.join()
        os.close(ours)
        os.close(other)
    assert re.fullmatch(
        r"the device at \S+ does not answer as \S+ says within 0.3 s \(.*\): is it .*\?", str(refused.value)
    )


def test_a_gripper_that_will_not_activate_is_refused_with_what_it_says(running, tmp_path):
    drive = running("robotiq-2f85")
    drive.path.write_text(drive.path.read_text().replace("patience = 12.0", "patience = 0.5"))
    drive.device.tell = lambda values, now: None  # noqa: ARG005
    drive.device.fault = 13
    with pytest.raises(
        DeviceError, match=r"answers, but is not 'activated' within 0.5 s; it says .* activation_failed"
    ):
        drive.open()


@pytest.mark.parametrize("name", ["robotiq-2f85", "robotiq-2f85-ur"])
def test_an_activation_that_failed_before_begins_anew(running, name):
    """It begins with the rising edge of rACT (manual, gFLT), which such a gripper has set already."""
    drive = running(name)
    drive.device.commanded["ACT"], drive.device._ready_at = 1, 1 << 62
    with drive.open() as endpoint:
        assert "activated" in endpoint.conditions


def test_a_port_that_is_busy_or_not_there_is_one_sentence(small):
    with small.open(), pytest.raises(DeviceError, match="another program has it"):
        small.open()
    with pytest.raises(DeviceError, match="there is no such file"):
        small.open(address="/dev/no-such-tty")
    assert remedy("serial", "x", OSError(16, "busy")).startswith("the device at x cannot be opened")


def flat(table, head=""):
    """Return the values of a table of tables by their whole path."""
    if not isinstance(table, dict):
        return {head: table}
    return {path: one for key, value in table.items() for path, one in flat(value, f"{head}.{key}").items()}


@pytest.mark.parametrize("ending", ["", "-ur"])
def test_the_maps_of_the_models_differ_in_names_and_forces_alone(ending):
    first, *others = (flat(whole(read_toml(map_of(name + ending)), name)) for name in MODELS)
    forces = {f".drive.{key}" for key in ("resolution", "minimum", "maximum", "hysteresis")}
    forces |= {f".fingers.*.command.{key}" for key in ("gain", "offset")}
    for other in others:
        differing = {key for key in first.keys() | other.keys() if first.get(key) != other.get(key)}
        assert differing <= {".like", ".product.name", *forces}


def test_a_map_that_is_like_no_product_is_refused_with_those_that_there_are(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('like = "robotiq-2f58"\n')
    with pytest.raises(ConfigError, match="'like' is 'robotiq-2f58'; did you mean robotiq-2f85"):
        open_plan(path)


def test_a_map_that_is_like_a_product_is_launched_as_one_that_says_all(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('like = "robotiq-2f140"\n[transport]\naddress = "/dev/ttyUSB3"\n')
    (node,) = read_launch_file(path)
    assert (node.fingers, node.parameters["limits"]["max_force"]) == (("jaw",), 60.0)
    assert {"kind": "serial", "baud": 115_200, "address": "/dev/ttyUSB3"}.items() <= node.transport.items()
