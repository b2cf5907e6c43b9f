"""The package ``canopen`` as the other side: its fingers, its master."""

import time
from itertools import count

import canopen
import pytest
from vegrip.nodes.grasp_force import build

from vegrip.canopen.network import unpack_time
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.runtime import NodeContext

from .conftest import (
    FINGERS,
    FINGERTIP,
    GRASP,
    GRASP_FORCE,
    INDEX,
    THUMB,
    eventually,
    hand_of_ours,
    protected,
)


def test_fingers_of_another_maker_are_checked_started_and_commanded(grasp, fingers, other):
    ours = grasp()
    made = {node: fingers(node) for node in (THUMB, INDEX)}
    eventually(lambda: ours.settled)
    assert [finger.nmt.state for finger in made.values()] == ["OPERATIONAL"] * 2
    index = made[INDEX]
    commands = []
    index.rpdo[1].add_callback(lambda pdo: commands.append(bytes(pdo.data)))
    for counter in range(3):
        index.tpdo[1].data[:] = protected(0x101, counter, (2500).to_bytes(2, "little") + bytes(4))
        index.tpdo[1].transmit()
        eventually(lambda n=counter: len(commands) > n)
    assert index.rpdo[1]["ForceCommand.normal_force"].raw == 1000  # [mN] what the echo answers
    assert index.rpdo[1]["ForceCommand.expires"].raw == 50  # [2 ms]
    before = dict(ours.endpoint.rejected)
    assert set(before) <= {"heartbeat_lost"}, "at most the fingers were slow to come"
    index.tpdo[1].data[0] ^= 1
    index.tpdo[1].transmit()
    eventually(lambda: ours.endpoint.rejected == before | {"checksum": 1})
    assert len(commands) == 3


def test_a_master_reads_and_sets_parameters_and_is_told_why_not(grasp, other):
    node = build({}, NodeContext("grasp_force", fingers=FINGERS))
    grasp(node, autostart=False)
    master = other.add_node(canopen.RemoteNode(GRASP, GRASP_FORCE))
    master.sdo.RESPONSE_TIMEOUT = 60.0
    assert master.sdo["Manufacturer device name"].raw == "vegrip grasp force"
    assert master.sdo["limits.max_force"].raw == pytest.approx(15.0)
    master.sdo["grip.wanted_margin"].raw = 0.25
    assert node.parameters.grip.wanted_margin == pytest.approx(0.25)
    with pytest.raises(canopen.SdoAbortedError) as refused:
        master.sdo["grip.wanted_margin"].raw = 7.0
    assert refused.value.code == 0x06090030
    assert "it must lie in 0 .. 0.9" in master.sdo["Last refusal"].raw
    with pytest.raises(canopen.SdoAbortedError) as refused:
        master.sdo["policy"].raw = "cone"
    assert refused.value.code == 0x08000022
    assert node.parameters.policy == "margin"
    master.sdo["fail_safe.force"].raw = 7.0
    assert node.parameters.fail_safe.force == 7.0
    with pytest.raises(canopen.SdoAbortedError):
        master.sdo.download(0x3000, 0, b"x" * 1000)


def test_the_nmt_state_is_the_lifecycle_state(grasp, other):
    ours = grasp(autostart=False)
    master = other.add_node(canopen.RemoteNode(GRASP, GRASP_FORCE))
    for command, nmt, lifecycle in (
        ("OPERATIONAL", "OPERATIONAL", "ACTIVE"),
        ("PRE-OPERATIONAL", "PRE-OPERATIONAL", "INACTIVE"),
        ("STOPPED", "STOPPED", "UNCONFIGURED"),
        ("OPERATIONAL", "OPERATIONAL", "ACTIVE"),
        ("RESET", "PRE-OPERATIONAL", "INACTIVE"),
    ):
        master.nmt.state = command
        eventually(lambda lifecycle=lifecycle: ours.state == lifecycle)
        eventually(lambda nmt=nmt: master.nmt.wait_for_heartbeat(60.0) == nmt)


def test_what_was_sent_can_be_read(grasp, fingers, other):
    ours = grasp()
    index = {node: fingers(node) for node in (THUMB, INDEX)}[INDEX]
    master = other.add_node(canopen.RemoteNode(GRASP, GRASP_FORCE))
    eventually(lambda: ours.settled)
    index.tpdo[1].data[:] = protected(0x101, 0, (2500).to_bytes(2, "little") + bytes(4))
    index.tpdo[1].transmit()
    eventually(lambda: master.sdo["ForceCommand 1"]["normal_force"].raw == 1000)
    assert master.sdo["ForceCommand 1"]["reason"].raw == Reason.HOLD
    assert master.sdo["Consumer heartbeat time"][2].raw == INDEX << 16 | 500


def test_a_hand_of_ours_obeys_a_master_of_another_maker(bus, other):
    with hand_of_ours(bus) as (heard, to_send, _):
        thumb = other.add_node(canopen.RemoteNode(THUMB, FINGERTIP))
        thumb.sdo.RESPONSE_TIMEOUT = 60.0
        assert thumb.nmt.wait_for_heartbeat(60.0) == "PRE-OPERATIONAL"
        thumb.tpdo.read()
        thumb.rpdo.read()
        received = []
        thumb.tpdo[1].add_callback(lambda pdo: received.append(pdo["State 1.normal_force"].raw))
        to_send.append(FingertipState(0, "thumb", 0, normal_force=1.0))
        eventually(lambda: not to_send)
        thumb.nmt.state = "OPERATIONAL"
        assert thumb.nmt.wait_for_heartbeat(60.0) == "OPERATIONAL"
        to_send.append(FingertipState(0, "thumb", 1, normal_force=2.5))
        eventually(lambda: received)
        assert received == [2500], "a finger that is not operational sends nothing"
        thumb.rpdo[1].data[:] = protected(0x040, 0, bytes([0xE8, 3, 0, 0, 0, 50]), last=False)
        thumb.rpdo[1].transmit()
        eventually(lambda: heard)
        assert isinstance(heard[0], ForceCommand)
        assert (heard[0].finger, heard[0].normal_force) == ("thumb", 1.0)


def test_a_finger_told_so_sends_with_every_second_sync(bus, other):
    with hand_of_ours(bus) as (_, to_send, __):
        thumb = other.add_node(canopen.RemoteNode(THUMB, FINGERTIP))
        thumb.sdo.RESPONSE_TIMEOUT = 60.0
        thumb.tpdo.read()
        thumb.sdo[0x1800][2].raw = 2
        received = []
        thumb.tpdo[1].add_callback(lambda pdo: received.append(pdo["State 1.normal_force"].raw))
        thumb.nmt.state = "OPERATIONAL"
        thumb.nmt.wait_for_heartbeat(60.0)
        for seq in range(3):
            to_send.append(FingertipState(0, "thumb", seq, normal_force=float(seq)))
        eventually(lambda: not to_send)
        time.sleep(0.05)
        assert received == []
        other.sync.transmit()
        time.sleep(0.05)
        assert received == []
        other.sync.transmit()
        eventually(lambda: received)
        assert received == [2000], "the newest state"


def test_the_time_of_a_master_is_followed(bus, other):
    with hand_of_ours(bus) as (_, __, endpoint):
        assert endpoint.clock is None
        for _ in range(3):
            other.time.transmit()
        eventually(lambda: endpoint.clock)
        offset = time.monotonic() - time.time()
        assert endpoint.clock.offset == pytest.approx(
            offset, abs=1.0
        )  # [s]; how well, test_sender_clock tells
        other.time.transmit(time.time() + 3600.0)
        eventually(lambda: endpoint.rejected.get("clock_jump"))
        other.send_message(0x100, b"no time")
        eventually(lambda: endpoint.rejected.get("malformed"))


def test_a_grasp_node_told_so_produces_time(grasp, other):
    heard = []
    other.subscribe(0x100, lambda _, data, __: heard.append(bytes(data)))
    grasp(time_period=0.1)
    eventually(lambda: len(heard) > 1)
    assert [unpack_time(data) / 1e9 for data in heard[:2]] == pytest.approx([time.time()] * 2, abs=60.0)
    ours = other.add_node(canopen.RemoteNode(GRASP, GRASP_FORCE))
    ours.sdo.RESPONSE_TIMEOUT = 60.0
    assert ours.sdo[0x1012].raw == 0x4000_0100


def test_states_in_pdos_are_answered_by_the_compiled_step(grasp, bus):
    """One finger after the other, because each waits for the command to its own state."""
    node = build({}, NodeContext("grasp_force", fingers=FINGERS))
    with hand_of_ours(bus) as (heard, to_send, hand):
        ours = grasp(node)
        eventually(lambda: ours.settled)
        assert ours.runner.path_taken.startswith("states are answered by the compiled step (")
        deadline = time.monotonic() + 300.0  # [s]; a late machine answers the newest states alone
        for seq in count():
            if ours.runner.statistics.states > 60 or time.monotonic() > deadline:
                break
            now = time.monotonic_ns()
            force = 2.0 + 0.01 * (seq % 7)
            to_send += [
                FingertipState(now, name, seq, normal_force=force, displacement=1e-3) for name in FINGERS
            ]
            eventually(lambda n=seq: sum(isinstance(one, ForceCommand) for one in heard) > 2 * n + 1)
        assert ours.runner.statistics.states > 60
        assert {one.finger for one in heard if isinstance(one, ForceCommand)} == set(FINGERS)
        refused = {"checksum", "length", "unknown_id", "value", "version"}
        assert not refused & {*hand.rejected, *ours.endpoint.rejected}
        commanded = ours.endpoint._mirror._frames
        assert {len(data) for data in commanded.values()} == {8}, "commands are kept to be read by SDO"
