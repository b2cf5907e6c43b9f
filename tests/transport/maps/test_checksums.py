"""Laws of the checksums of foreign hands."""

import zlib

import crccheck.crc
import pytest

from tests.transport.maps.hands import seeded
from vegrip.config import build
from vegrip.connect.find_protection import find_checksum
from vegrip.errors import ConfigError
from vegrip.transport.maps.checksums import PROFILES, ChecksumMap, make_crc, protection, table_crc
from vegrip.transport.maps.signals import ForeignMessage, Signal

ALL = {
    "Crc8": (8, crccheck.crc.Crc8),
    "Crc8Smbus": (8, crccheck.crc.Crc8Smbus),
    "Crc8Maxim": (8, crccheck.crc.Crc8Maxim),
    "Crc16Modbus": (16, crccheck.crc.Crc16Modbus),
    "CrcXmodem": (16, crccheck.crc.CrcXmodem),
    "Crc16Kermit": (16, crccheck.crc.CrcKermit),
    "Crc32": (32, crccheck.crc.Crc32),
    "Crc32Autosar": (32, crccheck.crc.Crc32Autosar),
}


def message(length=8, **signals):
    return ForeignMessage("M", 0x10, length, fd=length > 8, signals=dict(signals))


@pytest.mark.parametrize("name", ALL)
def test_a_crc_by_polynomial_is_the_one_of_the_catalogue(name):
    width, peer = ALL[name]
    data = seeded(1).randbytes(31)
    crc = make_crc(width, peer._poly, peer._initvalue, peer._xor_output, reflected=peer._reflect_input)
    assert crc(data) == peer.calc(data)


@pytest.mark.parametrize("start", [0, 0x5A, 0xFF])
@pytest.mark.parametrize("final", [0, 0xC3, 0xFF])
@pytest.mark.parametrize(
    ("width", "polynomial", "reflected"),
    [
        (8, 0x1D, False),
        (8, 0x2F, False),
        (16, 0x1021, False),
        (16, 0x8005, True),
        (32, 0x04C11DB7, True),
        (32, 0xF4ACFB13, True),
    ],
)
def test_the_quick_way_of_a_crc_is_the_slow_one(width, polynomial, reflected, start, final):
    data = seeded(4).randbytes(23)
    quick = make_crc(width, polynomial, start, final, reflected=reflected)
    assert quick(data) == table_crc(width, polynomial, start, final, reflected=reflected)(data)


def test_the_reflected_crc_32_is_that_of_zlib():
    data = seeded(2).randbytes(64)
    assert make_crc(32, 0x04C11DB7, 0xFFFFFFFF, 0xFFFFFFFF, reflected=True)(data) == zlib.crc32(data)


STORED = {
    "sum": {"kind": "sum"},
    "xor": {"kind": "xor", "start": 0x5A},
    "crc8": {"kind": "crc8", "polynomial": 0x1D, "start": 0xFF, "final": 0xFF},
    "crc8 with an ID": {"kind": "crc8", "polynomial": 0x2F, "data_id": [0x123], "id_bytes": "before"},
    "sum over a part": {"kind": "sum", "first": 2, "last": 5},
    "a nibble in a byte of more": {"kind": "xor", "own": "zero", "signal": "nibble"},
    "crc16": {"kind": "crc16", "polynomial": 0x1021, "start": 0xFFFF, "signal": "word"},
}


@pytest.mark.parametrize("name", STORED)
def test_what_was_protected_passes_and_any_bit_flipped_in_what_is_covered_does_not(name):
    spec = build(ChecksumMap, {"signal": "sum", **STORED[name]}, "map")
    layout = message(
        sum=Signal("sum", 0, 8), nibble=Signal("nibble", 4, 4), word=Signal("word", 7, 16, is_big_endian=True)
    )
    guard = protection(spec, layout, "map")
    data = bytearray(seeded(3).randbytes(8))
    guard.protect(data)
    assert guard.check(bytes(data))
    covered = range(2, 6) if "part" in name else range(8)
    for byte in covered:
        for bit in range(8):
            broken = bytearray(data)
            broken[byte] ^= 1 << bit
            assert not guard.check(bytes(broken)), (byte, bit)


@pytest.mark.parametrize("kind", ["sum", "xor"])
@pytest.mark.parametrize("start", [0, 0x5A, 0xC3])
def test_a_sum_is_found_whatever_it_starts_with(kind, start):
    layout = message(sum=Signal("sum", 56, 8))
    guard = protection(
        build(ChecksumMap, {"signal": "sum", "kind": kind, "start": start}, "map"), layout, "map"
    )
    frames = [bytearray(seeded(n).randbytes(8)) for n in range(9)]
    for data in frames:
        guard.protect(data)
    found = find_checksum(layout, "sum", [bytes(data) for data in frames])
    again = protection(build(ChecksumMap, found, "map"), layout, "map")
    other = bytearray(seeded(10).randbytes(8))
    guard.protect(other)
    assert again.check(bytes(other))
    other[3] ^= 1
    assert not again.check(bytes(other))
    assert find_checksum(layout, "sum", [seeded(n).randbytes(8) for n in range(9)]) is None


@pytest.mark.parametrize("kind", PROFILES)
def test_a_profile_of_autosar_refuses_a_flipped_bit_and_another_id(kind):
    length = 32 if kind in ("p04", "p05", "p06", "p07") else 8
    ids = list(range(16)) if kind == "p02" else [0x123]
    guard, other = (
        protection(build(ChecksumMap, {"kind": kind, "data_id": each}, "map"), message(length), "map")
        for each in (ids, [number + 1 for number in ids])
    )
    data = bytearray(length)
    guard.protect(data)
    assert guard.check(bytes(data))
    assert not other.check(bytes(data))
    data[-1] ^= 4
    assert not guard.check(bytes(data))


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"kind": "crc8", "signal": "sum"}, "'polynomial' is missing"),
        ({"kind": "sum", "signal": "summ"}, "must be the signal of M with the checksum"),
        ({"kind": "p05"}, "needs 1"),
        ({"kind": "p07", "data_id": [1]}, "takes at least 20"),
        ({"kind": "crc9"}, "must be one of"),
    ],
)
def test_what_cannot_be_a_checksum_is_refused_in_a_sentence(table, said):
    with pytest.raises(ConfigError, match=said):
        protection(build(ChecksumMap, table, "map"), message(sum=Signal("sum", 0, 8)), "map")
