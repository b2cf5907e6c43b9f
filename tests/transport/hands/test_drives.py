"""Laws of every drive in the box, and what its map cannot say."""

import math
from collections import Counter

import numpy as np
import pytest
from drives import command

from vegrip.clock import NS
from vegrip.config import read_toml
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState
from vegrip.transport.codec import Frame
from vegrip.transport.hands.device_endpoint import virtual_device
from vegrip.transport.hands.link_endpoint import MappedLinkEndpoint, PacketStream
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import make_plan, open_plan, read_database
from vegrip.transport.mapped.price import price
from vegrip.transport.maps.checksums import appended
from vegrip.transport.maps.conditions import ConditionMap, Conditions
from vegrip.transport.maps.modbus import framed, silence
from vegrip.transport.maps.products import about, map_of, names, virtual_text
from vegrip.transport.maps.schema import parse_map

DRIVES = [name for name in names() if not about(name)["channels"]]


@pytest.fixture(params=DRIVES)
def plan(request, tmp_path):
    path = tmp_path / f"{request.param}.toml"
    path.write_text(virtual_text(map_of(request.param)))
    return open_plan(path)


@pytest.mark.parametrize("name", DRIVES)
def test_each_says_where_it_is_from_and_that_it_was_not_tried(name):
    told = about(name)
    assert told["source"]
    assert told["tried_on"] == []
    assert told["commands"] in ("force", "current")


def test_each_says_what_it_can_do_and_what_happens_when_this_computer_dies(plan):
    drive = plan.hand.drive
    assert drive.rate > 0.0
    assert 0.0 <= drive.minimum < drive.maximum
    assert plan.hand.command.silence == "holds"
    said = price(plan)
    assert "jaw: it is a drive and feels nothing" in said
    assert any("when this computer dies, it keeps" in one or "it stops" in one for one in said)


def damaged(known, seed, longest):
    """Yield bytes that begin as known ones do, or do not, some with one byte changed."""
    rng = np.random.default_rng(seed)
    for _ in range(3000):
        head = known[rng.integers(len(known))] if rng.random() < 0.5 else b""
        data = bytearray(head + (rng.bytes(rng.integers(longest)) if rng.random() < 0.7 else b""))
        if data and rng.random() < 0.5:
            data[rng.integers(len(data))] = rng.integers(256)
        yield bytes(data)


def test_no_bytes_whatever_raise_in_a_simulated_drive(plan):
    device = virtual_device(plan)
    polls = plan.hand.device.poll
    known = [bytes.fromhex(one.get("data", "")) + one.get("text", "").encode() for one in polls]
    for number, data in enumerate(damaged(known, 4, 40)):
        now = number * NS // 100
        device.take_in(Frame(-1, data, False, now), now)
        device.due(now)
    assert device.counts["unknown_request"] > 0
    assert all(math.isfinite(force) for force in device.forces.values())


def test_no_bytes_whatever_raise_in_the_driver(plan):
    counts = Counter()
    stream = PacketStream(plan.database.packets, counts)
    codec = MappedCodec(plan)
    known = [plan.database.messages[packet.name].template for packet in plan.database.packets]
    found = 0
    for number, data in enumerate(damaged([*known, b"STA 3\n", b"OBJ x\n"], 5, 20)):
        for frame in stream.feed(data, number):
            codec.decode_all(frame)
            found += 1
    assert counts.total() + found > 0


def test_where_a_finger_presses_there_is_an_object(plan):
    device = virtual_device(plan)
    device.jaws.place = 30.0
    device.sense(FingertipState(0, "jaw", 0, normal_force=2.0))
    assert device.jaws.object_at == 30.0
    device.sense(FingertipState(0, "jaw", 1, normal_force=0.0))
    assert device.jaws.object_at is None


def test_the_checksum_of_modbus_is_the_one_of_the_catalogue_of_crcs():
    assert appended("modbus", b"123456789")[9:].hex() == "374b"
    assert framed("tcp", 7, bytes.fromhex("01 03 062E 0006")).hex() == "0007000000060103062e0006"


@pytest.mark.parametrize(
    ("baud", "seconds"), [(9600, 3.5 * 11 / 9600), (19200, 3.5 * 11 / 19200), (115200, 1.75e-3)]
)
def test_a_line_is_silent_for_three_and_a_half_characters_and_never_less_than_the_fixed_time(baud, seconds):
    assert silence(baud) == pytest.approx(seconds, rel=1e-3)


def test_a_condition_holds_after_another_once():
    counts = Counter()
    maps = {
        "holding": ConditionMap({"s.object": 2}, is_fault=False),
        "lost": ConditionMap({"s.object": 3}, after="holding"),
    }
    conditions = Conditions(maps, {"s": {"object": lambda data: data[0]}}, counts)
    seen = []
    for value in (3, 0, 2, 0, 3, 3, 0, 3, 2, 3):
        conditions.take("s", bytes([value]))
        seen.append("lost" in conditions.now)
    assert seen == [False, False, False, False, True, True, False, False, False, True]
    assert counts == {"lost": 2}


BAD = {
    "a condition without a field": ("conditions.holding.where", {"status.objekt": 1}, "mean status.object"),
    "a condition of no number": ("conditions.holding.where", {"status.object": "two"}, "takes whole numbers"),
    "a condition of nothing": ("conditions.holding.where", {}, "'where' is empty"),
    "after what is not": ("conditions.object_lost.after", "holdin", "did you mean holding"),
    "no unit on the line": ("modbus.unit", 300, "'unit'"),
    "no framing": ("modbus.framing", "ascii", "'framing'"),
    "too many registers": ("packets.status.registers", 200, "200 registers"),
    "no register": ("packets.status.read", 70_000, "the first register"),
    "registers that are no number": ("packets.status.registers", "3", "'3' registers"),
    "a field of no text": ("packets.status.fields.object", 5, "'fields', number"),
    "fields that are none": ("packets.status.fields", [1], "'fields' is [1]; it must be a table"),
    "a packet that is none": ("packets.status", 5, "'status' is 5; it must be a table"),
    "packets that are none": ("packets", [1], "'packets' is [1]; it must be a table"),
    "a device that is none": ("device", 5, "'device' is 5; it must be a table"),
    "a transport that is none": ("transport", [1], "'transport' is [1]; it must be a table"),
    "a rate of no number": ("transport.baud", "x", "'baud' is 'x'"),
    "a rate of nothing": ("transport.baud", 0, "'baud' is 0"),
    "no registers of modbus": ("modbus", 9, "'modbus' is 9; it must be a table"),
    "bytes that are none": ("device.opening", [{"write": 1, "data": "xyz"}], "'data' is 'xyz'"),
    "half a register": ("device.opening", [{"write": 1, "data": "010203"}], "write whole registers"),
    "an entry that is none": ("device.poll", ["status"], "'status' is no entry"),
    "an entry that reads a list": ("device.poll", [{"reads": ["status"]}], "'reads' is ['status']"),
    "an entry that reads nothing": ("device.poll", [{"reads": "statu"}], "'reads' is 'statu'"),
    "a motion without an end": ("fingers.*.command.closed", [], "needs 'closed'"),
    "no field for the motion": ("fingers.*.command.motion", "place", "place"),
    "a drive that cannot be": ("drive.minimum", 500.0, "the least force must be below the largest"),
    "ready by nothing": ("device.ready", "activate", "did you mean activated"),
    "an entry until nothing": ("device.opening", [{"reads": "status", "until": "x"}], "no condition 'x'"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_a_map_that_cannot_be_is_refused_in_one_sentence(case):
    keys, value, said = BAD[case]
    path = map_of("robotiq-2f85")
    table = read_toml(path)
    *inside, last = keys.split(".")
    place = table
    for key in inside:
        place = place[key]
    place[last] = value
    with pytest.raises(ConfigError) as refused:
        opened(table, path)
    assert said in str(refused.value)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


def opened(table, path):
    hand = parse_map(table, path)
    return MappedLinkEndpoint([], MappedCodec(make_plan(hand, read_database(hand), ("jaw",))))


def test_a_command_that_waits_for_its_turn_is_held_once_it_was_sent_and_its_time_is_over():
    path = map_of("robotiq-2f85")
    table = read_toml(path)
    hand = parse_map(table | {"command": table.get("command", {}) | {"silence": "unknown"}}, path)
    encoder = MappedCodec(make_plan(hand, read_database(hand), ("jaw",))).encoder
    encoder.encode(asked := command(50.0))
    encoder.due(asked.expires)
    assert encoder.held == 0  # it never left
    (outgoing,) = encoder.wanted()
    outgoing.message(asked.expires)
    encoder.due(asked.expires + NS)
    assert encoder.held == 1


def test_a_force_that_is_no_number_moves_nothing(plan):
    codec = MappedCodec(plan)
    for force in (math.nan, math.inf, -1.0):
        codec.encode(command(force))
    assert codec.encoder.wanted() == []
