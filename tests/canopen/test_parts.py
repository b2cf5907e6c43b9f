"""The pure parts: heartbeat consumer, reading by SDO, periodic messages, emergencies, identifiers."""

import struct

import can
import canopen
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.canopen.device import HEARTBEAT_LOST, NOT_ITS_EDS, Emergencies
from vegrip.canopen.hand_endpoint import HandEndpoint
from vegrip.canopen.network import (
    OF_A_FINGER,
    OPERATIONAL,
    STATE_OF,
    SYNC,
    TIME_COB_ID,
    CanopenSettings,
    LoopNetwork,
    finger_nodes,
    identifiers,
    pack_time,
    unpack_time,
)
from vegrip.canopen.sensors import ANSWER_TIMEOUT_NS, RETRIES, HeartbeatConsumer, SdoReader
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState, Lifecycle
from vegrip.transport.codec import CanCodec

MS = 1_000_000


def test_a_node_is_missing_once_when_it_is_silent_for_longer_than_its_limit():
    consumer = HeartbeatConsumer({32: 500 * MS}, 0)
    consumer.take_heartbeat(32, 5, 100 * MS)
    assert consumer.newly_missing(600 * MS) == []
    assert consumer.newly_missing(600 * MS + 1) == [32]
    assert consumer.newly_missing(700 * MS) == []
    assert (consumer.missing, consumer.state(32)) == ([32], None)


def test_a_node_that_was_never_there_is_missed_too():
    assert HeartbeatConsumer({32: 500 * MS}, 0).newly_missing(501 * MS) == [32]


def test_a_node_may_take_longer_to_appear_than_between_two_heartbeats():
    consumer = HeartbeatConsumer({32: 500 * MS}, 0, first=10_000 * MS)
    assert consumer.newly_missing(10_000 * MS) == []
    consumer.take_heartbeat(32, 127, 10_000 * MS)
    assert consumer.newly_missing(10_500 * MS) == []
    assert consumer.newly_missing(10_501 * MS) == [32]


def test_a_node_that_never_appears_is_missed():
    assert HeartbeatConsumer({32: 500 * MS}, 0, first=10_000 * MS).newly_missing(10_001 * MS) == [32]


def test_a_node_that_returns_is_there_again():
    consumer = HeartbeatConsumer({32: 500 * MS}, 0)
    consumer.newly_missing(1000 * MS)
    assert consumer.take_heartbeat(32, 127, 1000 * MS)
    assert not consumer.take_heartbeat(32, 5, 1100 * MS)
    assert (consumer.missing, consumer.state(32)) == ([], 5)


@given(st.lists(st.integers(0, 300), max_size=30))
def test_a_node_that_beats_within_its_limit_is_never_missing(gaps):
    consumer, now = HeartbeatConsumer({1: 300 * MS}, 0), 0
    for gap in gaps:
        now += gap * MS
        assert consumer.newly_missing(now) == []
        consumer.take_heartbeat(1, 5, now)


def answer(index, sub, value, size=4):
    command = 0x43 | (4 - size) << 2
    return struct.pack("<BHB", command, index, sub) + value.to_bytes(4, "little")


def test_objects_are_read_one_after_the_other_against_the_server_of_the_package():
    dictionary = canopen.import_od("proto/fingertip.eds", 32)
    network = LoopNetwork(lambda _, data: reader.answer(data, 0), lambda: 0)
    node = network.create_node(32, dictionary)
    asked = [(0x1018, 2), (0x1A00, 0), (0x1A00, 2), (0x1017, 0), (0x7777, 0)]
    reader = SdoReader(asked, lambda data: node.sdo.on_request(0x620, data, 0.0))
    reader.serve(0)
    assert reader.is_done
    assert list(reader.values.values()) == [1, 4, 0x20000210, 200, None]


def test_a_device_that_does_not_answer_is_asked_again_and_then_given_up():
    sent = []
    reader = SdoReader([(0x1000, 0)], sent.append)
    for n in range(RETRIES + 2):
        reader.serve(n * ANSWER_TIMEOUT_NS)
    assert (len(sent), reader.failed, reader.is_done) == (RETRIES, True, True)


@given(st.binary(max_size=12))
def test_no_answer_can_break_the_reader(data):
    reader = SdoReader([(0x1000, 0), (0x1018, 2)], lambda _: None)
    reader.serve(0)
    reader.answer(data, 0)
    reader.answer(answer(0x1000, 0, 7), 0)
    assert len(reader.values) >= 1


def test_periodic_messages_stay_on_their_grid_and_are_not_made_up_for():
    sent, clock = [], [0]
    network = LoopNetwork(lambda can_id, _: sent.append((can_id, clock[0] // MS)), lambda: clock[0])
    network.send_periodic(0x710, b"\x05", 0.2)
    for clock[0] in (0, 150 * MS, 230 * MS, 900 * MS, 1000 * MS):
        network.serve(clock[0])
    assert sent == [(0x710, t) for t in (0, 230, 900, 1000)]
    assert network.due == 1200 * MS


@pytest.mark.parametrize(
    ("kind", "arrived"),
    [(0, [0, 1, 1]), (1, [0, 1, 1]), (2, [0, 0, 1]), (240, [0, 0, 0]), (254, [1, 1, 1]), (255, [1, 1, 1])],
)
def test_a_state_leaves_by_itself_or_with_the_sync_that_its_transmission_type_says(kind, arrived):
    with can.Bus("sync", interface="virtual") as other:
        bus = can.Bus("sync", interface="virtual")
        hand = HandEndpoint(bus, CanCodec(("thumb",), fd=False), CanopenSettings(), (32,))
        hand.devices[32].store(0x1800, 2, bytes([kind]))
        hand.devices[32].set_state(OPERATIONAL)
        while other.recv(0) is not None:
            pass
        hand.send(FingertipState(1, "thumb", 0, normal_force=1.0))
        counts, states = [], 0
        for sync in range(3):
            if sync:
                hand.network.receive(SYNC, b"", sync)
            while (frame := other.recv(0)) is not None:
                states += frame.arbitration_id == OF_A_FINGER["FingertipState1"] + 32
            counts.append(int(states > 0))
        hand.can.close()
    assert counts == arrived


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_no_frame_can_break_the_services(can_id, data):
    network = LoopNetwork(lambda *_: None, lambda: 0)
    network.create_node(16, canopen.import_od("proto/fingertip.eds", 16))
    network.receive(can_id, data, 0)


def test_each_trouble_is_told_once_and_its_end_too():
    sent = []
    emergencies = Emergencies(lambda *frame: sent.append(frame))
    assert emergencies.begin(HEARTBEAT_LOST, 32, "x", 2)
    assert not emergencies.begin(HEARTBEAT_LOST, 32, "x", 2)
    assert emergencies.begin(NOT_ITS_EDS, 33, "y", 1)
    emergencies.end(HEARTBEAT_LOST, 32, 2)
    emergencies.end(HEARTBEAT_LOST, 32, 2)
    emergencies.end(NOT_ITS_EDS, 33, 2)
    assert [(code, register, data[:2]) for code, register, data in sent] == [
        (0x8130, 0x11, bytes([2, 32])),
        (0x6300, 0x11, bytes([1, 33])),
        (0x0000, 0x11, bytes([2, 32])),
        (0x0000, 0x00, bytes([2, 33])),
    ]


def test_every_lifecycle_state_has_an_nmt_state_the_package_knows():
    assert set(STATE_OF) == set(Lifecycle)
    assert set(STATE_OF.values()) <= set(canopen.nmt.NMT_STATES)


def test_identifiers_are_different_for_all_frames_of_all_hands():
    seen = []
    for hand in range(8):
        seen += identifiers(finger_nodes(32, hand, 8), 16 + hand, hand)
    assert len(seen) == len(set(seen)) == 8 * (8 * 6 + 1)
    with pytest.raises(ConfigError, match="127"):
        finger_nodes(100, 3, 8)


@given(st.integers(441_763_200_000, 441_763_200_000 + 65_535 * 86_400_000))
def test_time_is_packed_as_the_package_packs_it(milliseconds):
    """From 1984 to 2163; whole seconds, because the package goes by way of a float."""
    sent = []
    network = LoopNetwork(lambda cob_id, data: sent.append((cob_id, data)), lambda: 0)
    seconds = milliseconds // 1000
    network.time.transmit(seconds)
    assert sent == [(TIME_COB_ID, pack_time(1000 * seconds * MS))]
    assert unpack_time(pack_time(milliseconds * MS)) == milliseconds * MS


@pytest.mark.parametrize("data", [b"", bytes(5), bytes(7), (86_400_000).to_bytes(4, "little") + bytes(2)])
def test_what_is_no_time_is_none(data):
    assert unpack_time(data) is None
