"""What is wrong on the bus is a sentence, a name that is counted, an EMCY, and a state that all can see."""

import logging

import can
import canopen
import pytest

from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import Lifecycle, Reason
from vegrip.runtime.echo import EchoNode, EchoParameters
from vegrip.transport.open import Hand, open_endpoint

from .conftest import FINGERS, GRASP, GRASP_FORCE, INDEX, THUMB, eventually, protected


@pytest.fixture
def master(other):
    return other.add_node(canopen.RemoteNode(GRASP, GRASP_FORCE))


def emergency(master, code, lifecycle):
    """Return the EMCY of that code, sent in that state of the node, when it has come."""
    return eventually(
        lambda: next((e for e in master.emcy.log if (e.code, e.data[0]) == (code, lifecycle)), None)
    )


def sentences(ours):
    return list(ours.endpoint.device.emergencies.standing.values())


def test_a_missing_finger_keeps_the_node_from_becoming_active_and_everybody_is_told(grasp, fingers, master):
    ours = grasp(first_heartbeat=0.5)
    fingers(THUMB)
    eventually(lambda: len(sentences(ours)) == 1)
    told = emergency(master, 0x8130, Lifecycle.INACTIVE)
    assert told.register == 0x11
    assert "no heartbeat from index (node 33)" in sentences(ours)[0]
    assert master.nmt.wait_for_heartbeat(60.0) == "PRE-OPERATIONAL"
    assert ours.endpoint.rejected["heartbeat_lost"] >= 1
    fingers(INDEX)
    eventually(lambda: ours.state == "ACTIVE" and sentences(ours) == [])


@pytest.mark.parametrize(("behaviour", "state"), [(1, "OPERATIONAL"), (0, "PRE-OPERATIONAL"), (2, "STOPPED")])
def test_a_finger_that_falls_silent_is_told_and_the_node_does_what_object_1029_says(
    grasp, fingers, master, behaviour, state
):
    ours = grasp(names=("thumb",))
    thumb = fingers(THUMB)
    eventually(lambda: ours.state == "ACTIVE")
    master.sdo.RESPONSE_TIMEOUT = 60.0
    master.sdo["Error behaviour"][1].raw = behaviour
    thumb.nmt.stop_heartbeat()
    assert emergency(master, 0x8130, Lifecycle.ACTIVE).data[1] == THUMB
    eventually(lambda: master.nmt.wait_for_heartbeat(60.0) == state)
    if behaviour == 1:
        assert master.sdo[0x1001].raw == 0x11
        thumb.nmt.start_heartbeat(100)
        eventually(lambda: sentences(ours) == [])


def test_a_device_that_is_not_what_its_eds_says_is_not_listened_to(grasp, fingers, master):
    ours = grasp(names=("thumb",))
    fingers(THUMB, eds=GRASP_FORCE)
    assert emergency(master, 0x6300, Lifecycle.INACTIVE).data[1] == THUMB
    (sentence,) = (s for s in sentences(ours) if "fingertip.eds" in s)
    assert (
        sentence
        == "thumb (node 32) is not what fingertip.eds says: object 1018sub2 is 0x2, its EDS says 0x1; "
        "connect the right device, or give its EDS (transport.finger_eds)"
    )
    assert master.nmt.wait_for_heartbeat(60.0) == "PRE-OPERATIONAL"
    assert ours.endpoint.rejected["not_its_eds"] == 1


def test_a_node_id_that_is_taken_is_not_used_and_everybody_is_told(bus, other, fingers):
    fingers(GRASP)
    told = []
    other.subscribe(0x80 + GRASP, lambda _, data, __: told.append(bytes(data)))
    with pytest.raises(DeviceError, match="node-ID 16 is taken") as caught:
        open_endpoint({"kind": "canopen", **bus}, Hand(FINGERS))
    assert "\n" not in str(caught.value)
    eventually(lambda: told)
    assert told[0][:5] == bytes([0x50, 0x81, 0x11, Lifecycle.UNCONFIGURED, GRASP])


def test_a_second_node_with_our_id_is_told_and_the_grip_goes_on(grasp, fingers, master, bus):
    ours = grasp(names=("thumb",))
    fingers(THUMB)
    eventually(lambda: ours.state == "ACTIVE")
    with can.Bus(**bus) as rude:
        rude.send(can.Message(arbitration_id=0x700 + GRASP, data=[0], is_extended_id=False))
        assert eventually(lambda: [e for e in master.emcy.log if e.code == 0x8150])[0].data[1] == GRASP
    assert any("another node has the node-ID 16" in one for one in sentences(ours))
    assert ours.state == "ACTIVE"


class Failing(EchoNode):
    """Answers one state and fails at the next."""

    def on_message(self, message, now):
        if getattr(message, "seq", 0) >= 1:
            raise RuntimeError("broken")
        return super().on_message(message, now)


def test_a_node_that_fails_goes_on_with_its_last_commands_and_says_so(grasp, fingers, master):
    ours = grasp(
        Failing("grasp_force", EchoParameters()), names=("thumb",), heartbeat_limit=60.0
    )  # late is not lost
    thumb = fingers(THUMB)
    commands = []
    thumb.rpdo[1].add_callback(lambda pdo: commands.append((pdo["ForceCommand.reason"].raw, bytes(pdo.data))))
    eventually(lambda: ours.settled)
    for counter in range(2):
        thumb.tpdo[1].data[:] = protected(0x100, counter, (2500).to_bytes(2, "little") + bytes(4))
        thumb.tpdo[1].transmit()
        eventually(lambda n=counter: len(commands) > n)
    assert emergency(master, 0x6100, Lifecycle.INACTIVE).register == 0x01
    assert master.nmt.wait_for_heartbeat(60.0) == "OPERATIONAL"
    assert commands[-1][0] == Reason.INPUT_HOLD
    assert "last safe commands are held" in sentences(ours)[0]
    eventually(lambda: ours.state == "ACTIVE" and not sentences(ours))


def test_identifiers_that_collide_are_refused_before_the_bus_is_opened():
    with pytest.raises(ConfigError, match="that of a finger"):
        open_endpoint({"kind": "canopen", "node_id": THUMB, "channel": "never"}, Hand(FINGERS))


def test_a_frame_of_the_wrong_length_is_counted_and_nothing_else(grasp, bus):
    ours = grasp(autostart=False)
    with can.Bus(**bus) as rude:  # stays open until all has left
        for identifier in (0x000, 0x600 + GRASP, 0x700 + GRASP, 0x580 + THUMB, 0x700 + THUMB, 0x180 + THUMB):
            for data in (b"", b"\x01", b"\x40\x00"):
                rude.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
        eventually(lambda: ours.endpoint.device.foreign >= 3)
    assert ours.state == "INACTIVE"


LIMIT = 0.5  # [s]
BEATS = 5  # of ours, 0.2 s each: longer than the limit


def test_fingers_that_come_later_than_the_limit_of_a_heartbeat_raise_no_alarm(grasp, fingers, other, caplog):
    caplog.set_level(logging.INFO, "vegrip")
    beats, emergencies = [], []
    other.subscribe(0x700 + GRASP, lambda *_: beats.append(1))
    other.subscribe(0x80 + GRASP, lambda _, data, __: emergencies.append(bytes(data)))
    ours = grasp(heartbeat_limit=LIMIT, first_heartbeat=600.0)
    eventually(lambda: len(beats) > BEATS)
    assert "waits for thumb (node 32), index (node 33)" in caplog.text
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert not [data for data in emergencies if any(data)]
    assert "heartbeat_lost" not in ours.endpoint.rejected
    fingers(THUMB)
    fingers(INDEX)
    eventually(lambda: ours.state == "ACTIVE")
