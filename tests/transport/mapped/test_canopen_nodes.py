"""A CANopen hand beyond its PDOs: restarts, heartbeats, emergencies, and objects that only SDO reads."""

import time
from collections import Counter
from contextlib import closing
from pathlib import Path

import can
import canopen
import pytest

from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec import Frame
from vegrip.transport.hands.endpoints import MappedCanEndpoint
from vegrip.transport.mapped.canopen_nodes import CanopenNodes, read_eds
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import price

EDS = Path(__file__).parents[3] / "proto" / "fingertip.eds"
MS = 1_000_000
MAP = """
database = "their.eds"
rate = 100.0
nodes = { thumb = 32 }
[fingers.thumb.normal_force]
signal = "thumb_SDO.State_1_normal_force"
unit = "mN"
[fingers.thumb.displacement]
signal = "thumb_SDO.State_2_displacement"
unit = "um"
zero_is_measured = true
[fingers.thumb.command]
signal = "thumb_SDO_WRITE.ForceCommand_normal_force"
unit = "mN"
"""


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "their.eds").write_text(EDS.read_text())
    (tmp_path / "hand.toml").write_text(MAP)
    return open_plan(tmp_path / "hand.toml")


def frame(identifier, *data, stamp=1):
    return Frame(identifier, bytes(data), False, stamp)


def test_a_node_that_was_switched_off_and_on_is_started_again_and_counted(plan):
    codec = MappedCodec(plan)
    codec.decode_all(frame(0x720, 0x00))
    assert Frame(0, bytes([1, 32])) in codec.due(0)
    assert Frame(0, bytes([1, 32])) not in codec.due(1)
    assert codec.rejected["restarted"] == 1
    assert codec.foreign == 0


def test_a_node_that_is_not_operational_and_an_emergency_are_counted_by_name(plan):
    codec = MappedCodec(plan)
    for state in (0x7F, 0x04, 0x05):
        codec.decode_all(frame(0x720, state))
    codec.decode_all(frame(0xA0, 0x30, 0x81, 0x11, 0, 0, 0, 0, 0))
    codec.decode_all(frame(0xA0, 0, 0, 0x11, 0, 0, 0, 0, 0))  # it is over
    codec.decode_all(frame(0x721, 0x7F))  # of another node
    codec.decode_all(frame(0xA1, 0x30, 0x81, 0x11, 0, 0, 0, 0, 0))
    assert codec.rejected["not_operational"] == 2
    assert codec.rejected["emergency"] == 1
    assert codec.foreign == 2


@pytest.mark.parametrize(
    ("code", "counted"), [((0, 0), 0), ((0, 0x81), 1), ((0x30, 0x81), 1), ((0x01, 0), 1), ((0, 0x10), 1)]
)
def test_an_emergency_of_every_code_but_0_is_counted(code, counted):
    """The code stands in the first two bytes, the lower one first: 8100h is sent as 00 81."""
    nodes = CanopenNodes([32], [], 5 * MS, Counter())
    assert nodes.receive(frame(0xA0, *code, 0x11, 0xFF, 0xFF, 0, 0, 0))
    assert nodes.rejected["emergency"] == counted


def test_an_object_that_is_named_twice_is_asked_for_once_a_round():
    objects = [(32, 0x2000, 1), (32, 0x2001, 0), (32, 0x2000, 1), (32, 0x2002, 7), (32, 0x2001, 0)]
    nodes = CanopenNodes([32], objects, 5 * MS, Counter())
    asked = []
    for n in range(6):
        asked += [one.data[1:4].hex() for one in nodes.due(5 * n * MS) if one.arbitration_id == 0x620]
        assert nodes.receive(frame(0x5A0, 0x4F, 0, 0x20, 1, 7, 0, 0, 0))
    assert asked == ["002001", "012000", "022007"] * 2


def test_a_bus_that_is_opened_again_has_its_nodes_started_anew(plan):
    """Whether they ran before says nothing: a quarter of a second after the opening each is asked to."""
    codec, start = MappedCodec(plan), Frame(0, bytes((1, 32)))
    codec.decode_all(frame(0x720, 0x05))
    assert not any(start in codec.due(now * 100 * MS) for now in range(10))
    assert codec.begin() == [start]
    assert [now for now in range(10, 16) if start in codec.due(now * 100 * MS)] == [13]


def test_one_request_of_a_node_is_on_its_way_at_a_time_and_one_without_answer_is_given_up():
    rejected = Counter()
    objects = [(32, 0x2000, 1), (32, 0x2001, 0), (32, 0x2002, 7), (33, 0x2000, 1)]
    nodes = CanopenNodes([32, 33], objects, 5 * MS, rejected)
    first = nodes.due(0)
    assert [(one.arbitration_id, one.data.hex()) for one in first] == [
        (0x620, "4000200100000000"),
        (0x621, "4000200100000000"),
    ]
    assert nodes.due(10 * MS) == []
    assert nodes.receive(frame(0x5A0, 0x4F, 0, 0x20, 1, 7, 0, 0, 0))
    (second,) = nodes.due(11 * MS)
    assert second.data[:4].hex() == "40012000"
    assert nodes.receive(frame(0x5A0, 0x80, 1, 0x20, 0, 0, 0, 2, 6))
    assert rejected["sdo_abort"] == 1
    assert nodes.due(16 * MS - 1) == []
    (third,) = nodes.due(16 * MS)
    assert third.data[:4].hex() == "40022007"
    assert nodes.due(50 * MS - 1) == []
    assert [one.arbitration_id for one in nodes.due(50 * MS)] == [0x621]
    assert rejected["sdo_timeout"] == 1
    assert nodes.receive(frame(0x5A0, 0x4F, 2, 0x20, 7, 7, 0, 0, 0))
    assert [one.data for one in nodes.due(51 * MS)] == [first[0].data]


def test_an_answer_that_refuses_is_no_value(plan):
    codec = MappedCodec(plan)
    ask = next(one for one in codec.due(0) if one.arbitration_id == 0x620)
    assert codec.decode_all(frame(0x5A0, 0x80, *ask.data[1:4], 0, 0, 2, 6)) == []
    (state,) = codec.decode_all(frame(0x5A0, 0x4B, *ask.data[1:4], 0xDC, 0x05, 0, 0))
    assert state.normal_force == pytest.approx(1.5)
    assert not any(one.data[:1] == ask.data[:1] for one in codec.due(5 * MS - 1))
    assert any(one.data[:1] == ask.data[:1] for one in codec.due(5 * MS))


class Heard:
    """Stands for a network: keeps what a node sends."""

    def __init__(self):
        self.said = []

    def send_message(self, _identifier, data, *_):
        self.said.append(bytes(data))

    def subscribe(self, *_): ...


@pytest.mark.parametrize(
    ("kind", "sizes"), [("0x0003", {1, 2}), ("0x0010", {1, 2, 3}), ("0x0004", {1, 2, 4})]
)
def test_objects_of_every_size_are_read_and_written_as_an_sdo_server_answers(tmp_path, kind, sizes):
    """Signed objects of 16, 24 and 32 bits; the server is that of the library."""
    path = tmp_path / "their.eds"
    path.write_text(EDS.read_text().replace("DataType=0x0003", f"DataType={kind}"))
    network, node = Heard(), canopen.LocalNode(32, str(path))
    node.associate_network(network)
    messages, seen = read_eds(path, {"thumb": 32}).messages, set()
    for name, is_written in (("thumb_SDO", False), ("thumb_SDO_WRITE", True)):
        message = messages[name]
        assert (message.identifier, message.length, message.fd) == (0x620 if is_written else 0x5A0, 8, False)
        for signal in (one for one in message.signals.values() if one.selectors):
            selector, size = signal.selectors[0].to_bytes(4, "little"), signal.length // 8
            index, sub = int.from_bytes(selector[1:3], "little"), selector[3]
            node.set_data(index, sub, b"\1\2\3\4"[:size])
            asked = selector + b"\5\6\7\0" if is_written else b"\x40" + selector[1:] + bytes(4)
            node.sdo.on_request(0x620, bytearray(asked), 0.0)
            answer = network.said.pop()
            if is_written:
                assert selector[0] == 0x23 | (4 - size) << 2
                assert answer[0] == 0x60
                assert node.get_data(index, sub) == b"\5\6\7\0"[:size]
            else:
                assert answer == selector + b"\1\2\3\4"[:size] + bytes(4 - size)
                assert signal.selectors[1] == signal.selectors[0] & ~0xFF | 0x42
            seen.add((size, is_written))
    assert seen == {(size, is_written) for size in sizes for is_written in (False, True)}


def test_the_owner_is_told_that_values_are_not_of_one_moment(plan):
    said = price(plan)
    assert any("asked for one after the other" in sentence for sentence in said)
    assert not any("SDO_WRITE: sent as zero" in sentence for sentence in said)


def test_a_device_with_an_sdo_server_is_read_and_commanded_over_sdo_alone(plan):
    channel = "sdo-only"
    device = canopen.Network()
    device.connect(interface="virtual", channel=channel)
    try:
        node = device.create_node(32, str(EDS))
        names = {
            signal: place.selectors[0]
            for signal, place in plan.database.messages["thumb_SDO"].signals.items()
            if place.selectors
        }
        written = plan.database.messages["thumb_SDO_WRITE"].signals["ForceCommand_normal_force"].selectors[0]

        def entry(where):
            return node.sdo[where >> 8 & 0xFFFF][where >> 24]

        entry(names["State_1_normal_force"]).raw = 1500
        entry(names["State_2_displacement"]).raw = 1000
        bus = can.Bus(interface="virtual", channel=channel)
        with closing(MappedCanEndpoint(bus, MappedCodec(plan))) as endpoint:
            end = time.monotonic() + 60.0
            state = None
            while state is None or state.displacement != state.displacement or entry(written).raw != 2000:
                assert time.monotonic() < end
                state = next(iter(endpoint.receive(0.01)), state)
                now = time.monotonic_ns()
                endpoint.send(ForceCommand(now, "thumb", 0, 2.0, 0.0, Reason.HOLD, now + 100 * MS))
            assert state.normal_force == pytest.approx(1.5)
            assert state.displacement == pytest.approx(1e-3)
            assert "sdo_abort" not in endpoint.rejected
    finally:
        device.disconnect()
