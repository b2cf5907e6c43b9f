"""Packets out of streams that are cut, merged, corrupted and full of noise; packed here by struct alone."""

import itertools
import struct
from collections import Counter
from pathlib import Path

import pytest

from tests.transport.maps.hands import seeded
from vegrip.errors import ConfigError
from vegrip.transport.hands.link_endpoint import PacketStream
from vegrip.transport.maps.packet_database import packet_database
from vegrip.transport.maps.packets import MOST_BYTES, read_packets
from vegrip.transport.maps.schema import parse_map

NOW = 1_000_000


def x25(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    return value ^ 0xFFFF


def fixed(rng):
    body = struct.pack("<Hf", rng.randrange(1 << 16), rng.gauss(0, 5))
    return b"\xaa" + body + struct.pack("<H", x25(body))


def counted(rng):
    body = rng.randbytes(rng.randrange(3, 40))
    head = b"\x55\xaa" + bytes([len(body), 7]) + body
    return head + bytes([-sum(head) & 0xFF])


def ended(rng):
    body = rng.randbytes(rng.randrange(4, 60))
    return b"\x55\x66\x77\x88" + body + struct.pack("<H", sum(body) & 0xFFFF) + b"\xaa\xbb\xcc\xdd"


PACKETS = {
    "fixed": (
        fixed,
        {
            "start": "AA",
            "length": 9,
            "checksum": {"kind": "x25", "signal": "crc", "first": 1},
            "fields": {"n": "u16 le @1", "f": "f32 le @3", "crc": "u16 le @7"},
        },
    ),
    "counted": (
        counted,
        {
            "start": "55 AA .. 07",
            "length": {"field": "u8 @2", "plus": 5, "most": 64},
            "checksum": {"kind": "lrc", "signal": "lrc"},
            "fields": {"a": "i8 @4", "lrc": "u8 @-1"},
        },
    ),
    "ended": (
        ended,
        {
            "start": "55 66 77 88",
            "end": "AA BB CC DD",
            "length": "end",
            "checksum": {"kind": "sum", "signal": "sum", "first": 4, "last": -5},
            "fields": {"a": "u32 le @4", "sum": "u16 le @-6"},
        },
    ),
}


def stream(*names, counts=None, **others):
    tables = {name: PACKETS[name][1] for name in names} | others
    database = packet_database(read_packets(tables, "map"), "map")
    return PacketStream(database.packets, Counter() if counts is None else counts)


def test_the_crc_here_is_the_one_of_the_catalogue():
    assert x25(b"123456789") == 0x906E


def is_sound(packet):
    """Whether a checksum of eight bits, which noise meets once in 256, says so."""
    return (
        packet[:2] == b"\x55\xaa"
        and packet[3] == 7
        and len(packet) == packet[2] + 5
        and sum(packet) & 0xFF == 0
    )


@pytest.mark.parametrize("names", [("fixed",), ("counted",), ("ended",), ("fixed", "ended")], ids="+".join)
def test_of_10000_hostile_chunks_every_sound_packet_is_found_and_nothing_else(names):
    rng = seeded(31)
    counts = Counter()
    heard = stream(*names, counts=counts)
    sent, found, wire = [], [], bytearray()
    for _ in range(6000):
        packet = PACKETS[rng.choice(names)][0](rng)
        harm = rng.random()
        if harm < 0.6:
            sent.append(packet)
        elif harm < 0.7:
            packet = packet[: rng.randrange(len(packet))]
        elif harm < 0.85:
            place = rng.randrange(len(packet))
            packet = packet[:place] + bytes([packet[place] ^ 1 << rng.randrange(8)]) + packet[place + 1 :]
        elif harm < 0.95:
            packet = rng.randbytes(rng.randrange(1, 80))
        else:
            packet = packet[: rng.randrange(5)] * rng.randrange(1, 20)
        wire += packet
    wire += bytes(2 * MOST_BYTES)  # so that what was begun is given up
    chunks = 0
    while wire:
        size = rng.choice((1, 2, 3, 7, 11))
        found += [frame.data for frame in heard.feed(bytes(wire[:size]), NOW)]
        del wire[:size]
        chunks += 1
        assert heard.pending <= MOST_BYTES
    assert chunks > 10_000
    if names == ("counted",):
        assert all(map(is_sound, found))
        assert len(set(sent) - set(found)) <= 0.005 * len(sent)
    else:
        assert found == sent
    assert counts["bad_checksum"] > 100
    assert counts["resync"] > 100


def test_nothing_that_can_come_raises():
    rng = seeded(32)
    heard = stream(*PACKETS, whole={"start": "01", "fields": {"a": "u64 be @1"}}, index=INDEXED)
    for _ in range(10_000):
        chunk = rng.randbytes(rng.randrange(40))
        if rng.random() < 0.5:
            chunk = rng.choice((b"\x01", b"\xaa", b"\x55\xaa", b"\x55\x66\x77\x88", b"\x99")) + chunk
        heard.datagram(chunk, NOW)
        heard.feed(chunk, NOW)


INDEXED = {
    "start": "99",
    "length": 40,
    "index": {"at": 1, "type": "u16 le @0", "offset": "u8 @2", "from": 1},
}
RECORDS = {
    "index": INDEXED,
    "forces": {"of": "index", "record": 4, "start": "02 00", "fields": {"f": "f32 le @2"}},
    "time": {"of": "index", "record": 1, "fields": {"t": "u32 le @0"}},
}


def indexed(entries, body):
    table = b"".join(struct.pack("<HB", kind, offset) for kind, offset in entries)
    return (b"\x99" + table + body).ljust(40, b"\0")


@pytest.mark.parametrize(
    ("entries", "body", "found", "bad"),
    [
        (((1, 6), (4, 10)), struct.pack("<IHf", 7, 2, 2.5), 2, 0),
        (((4, 6), (1, 12)), struct.pack("<HfI", 2, 2.5, 7), 2, 0),
        (((9, 6), (4, 10)), struct.pack("<IHf", 7, 2, 2.5), 1, 0),  # a record nobody asked for
        (((1, 6), (4, 10)), struct.pack("<IHf", 7, 3, 2.5), 1, 1),  # another form of it
        (((1, 6), (4, 36)), struct.pack("<I", 7), 1, 1),  # cut by the end
        (((1, 200), (4, 10)), b"", 0, 1),  # beyond it
        (((1, 0), (4, 10)), b"", 0, 1),  # into the index itself
    ],
)
def test_records_are_found_by_their_index_wherever_they_stand(entries, body, found, bad):
    counts = Counter()
    database = packet_database(read_packets(RECORDS, "map"), "map")
    heard = PacketStream(database.packets, counts)
    frames = heard.feed(indexed(entries, body), NOW)
    assert len(frames) == found
    assert counts["bad_record"] == bad
    by_number = {message.identifier: name for name, message in database.messages.items()}
    for frame in frames:
        if by_number[frame.arbitration_id] == "forces":
            assert struct.unpack_from("<Hf", frame.data) == (2, 2.5)
        else:
            assert struct.unpack_from("<I", frame.data) == (7,)


TAGGED = {
    "tagged": {
        "start": "9A",
        "length": {"field": "u8 @1", "plus": 2},
        "index": {"at": 2, "type": "u8 @0", "mask": 0xFC, "sizes": {"0x10": 3, "0x20": 2}},
    },
    "wanted": {"of": "tagged", "record": 0x10, "fields": {"v": "u16 be @1"}},
}


@pytest.mark.parametrize(
    ("body", "values"),
    [
        ("10 0102 20 FF 11 0304", [0x0102, 0x0304]),
        ("20 FF", []),
        ("10 0102 20", None),  # cut
        ("10 0102 30 0102", None),  # of a size that is not known
        ("", []),
    ],
)
def test_records_one_behind_the_other_must_fill_their_packet(body, values):
    counts = Counter()
    database = packet_database(read_packets(TAGGED, "map"), "map")
    heard = PacketStream(database.packets, counts)
    data = bytes.fromhex(body)
    frames = heard.feed(bytes([0x9A, len(data)]) + data + bytes(300), NOW)
    assert [struct.unpack_from(">H", frame.data, 1)[0] for frame in frames] == (values or [])
    assert (counts["bad_record"] > 0) == (values is None)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (fixed(seeded(1))[:-1], "short"),
        (fixed(seeded(1)) + b"\0", "long"),
        (b"\xbb" + fixed(seeded(1))[1:], "unknown_packet"),
        (b"", "unknown_packet"),
        (fixed(seeded(1))[:-1] + b"\0", "bad_checksum"),
    ],
)
def test_a_datagram_is_one_whole_packet_or_is_counted_by_name(data, said):
    counts = Counter()
    heard = stream("fixed", counts=counts)
    assert heard.datagram(data, NOW) == []
    assert counts == {said: 1}
    assert [frame.data for frame in heard.datagram(fixed(seeded(1)), NOW)] == [fixed(seeded(1))]


def test_the_time_of_a_device_runs_on_where_its_count_wraps():
    table = {"start": "AA", "length": 5, "clock": "t us", "fields": {"t": "u32 le @1"}}
    heard = stream(clocked=table)
    stamps = []
    for number in range(2000):
        ticks = ((1 << 32) - 1_000_000 + 1000 * number) & 0xFFFFFFFF
        late = 3_000_000 if number % 7 else 0
        (frame,) = heard.feed(struct.pack("<BI", 0xAA, ticks), 10**12 + 1_000_000 * number + late)
        stamps.append(frame.stamp)
    steps = [after - before for before, after in itertools.pairwise(stamps[100:])]
    assert max(steps) < 1_100_000
    assert min(steps) > 900_000  # 1 ms, whatever the way took
    assert heard.clocks[0].jumps == 0


MAP = """
[packets.p]
{packet}
[fingers.thumb.normal_force]
signal = "p.fz"
"""
GOOD = 'start = "AA"\nlength = 5\nfields = { fz = "f32 le @1" }'


@pytest.mark.parametrize(
    ("packet", "said"),
    [
        (GOOD.replace("f32 le @1", "f31 le @1"), "write it like 'f32 le @2'"),
        (GOOD.replace("f32 le @1", "f32 @1"), "say its byte order"),
        (GOOD.replace("f32 le @1", "u12 be @1"), "no whole bytes"),
        (GOOD.replace("f32 le @1", "f32 le @-4"), "counted from the end"),
        (GOOD.replace('"AA"', '"AG"'), "are no bytes"),
        (GOOD.replace('"AA"', '"A"'), "are no bytes"),
        (GOOD.replace("5", "4"), "its fields need 5"),
        (GOOD.replace("5", "'end'"), "'end' beside end"),
        (GOOD.replace("5", "{ plus = 3 }"), "'field' is missing"),
        (GOOD + '\ncounter = "n"', "there is no field 'n'"),
        (GOOD + '\nvalid = { fz = "many" }', "give a number, a list"),
        (GOOD + '\nclock = "fz us"', "whole number of 8, 16"),
        (GOOD + '\nchecksum = { kind = "x25" }', "'checksum' must name the field"),
        (GOOD + '\nof = "q"', "must name a packet with an 'index'"),
        (GOOD + '\nlike = "p"', "'like' is 'p'"),
        (GOOD + "\nlenght = 5", "unknown key 'lenght'"),
        ("fields = 3", "it must be"),
        ('text = "SET {fz} {a-b}"', "its numbers are {name}"),
        ('text = "SET {fz} {"', "its numbers are {name}"),
        ('text = "SET {fz} {0}"', "its numbers are {name}"),
        ('text = "SET {fz} {fz}"', "each of another name"),
        ('text = "SET {fz} \u2026"', "must be those of Latin-1"),
    ],
)
def test_a_packet_that_cannot_be_is_refused_in_one_sentence(packet, said, tmp_path):
    from vegrip.config import parse_toml
    from vegrip.transport.mapped.plan import read_database

    with pytest.raises(ConfigError, match=said.replace("(", r"\(")) as caught:
        read_database(parse_map(parse_toml(MAP.format(packet=packet)), Path("hand.toml")))
    assert "\n" not in str(caught.value)
