"""Whole numbers of 64 bits, bytes and bits in C are what they are in Python."""

import ctypes
import math
import random
import struct
import textwrap
from pathlib import Path

import numpy as np
import pytest

from vegrip.c99 import BYTES, LONGS, MEMORY, UntranslatableError, host, translate
from vegrip.grip.kernels.bits import bits_of_real, real_of_bits

STRICT = ("-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
TEXT = """
    LARGE = 4294967295
    BIG = 9000000000000000000

    def entry(m, t, b):
        t[0] = t[1] + t[2] * 3 - 7
        t[3] = t[1] // 1000
        t[4] = t[1] % 1000
        t[5] = (t[1] & LARGE) ^ (t[2] | 5)
        t[6] = min(t[1], t[2]) - max(t[1], 4)
        t[7] = int(b[0]) << 24 | int(b[1]) << 16 | int(b[2]) << 8 | int(b[3])
        t[8] = t[7] >> 5
        t[9] = 1 if t[1] > t[2] else BIG
        t[10] = 3 << 40
        m[0] = float(t[1] - t[2]) / 1e9
        m[1] = real_of_bits(t[7])
        m[2] = real_of_bits(bits_of_real(m[3]))
        b[4] = t[1] & 255
        b[5] = (t[1] >> 8) & 255
        for i in range(b[6] & 3):
            m[4] += float(i) + float(t[1])
"""


def expected(m: list[float], t: list[int], b: list[int]) -> None:
    """What the text means, in plain Python."""
    t[0] = t[1] + t[2] * 3 - 7
    t[3], t[4] = t[1] // 1000, t[1] % 1000
    t[5] = (t[1] & 0xFFFFFFFF) ^ (t[2] | 5)
    t[6] = min(t[1], t[2]) - max(t[1], 4)
    t[7] = int.from_bytes(bytes(b[:4]), "big")
    t[8] = t[7] >> 5
    t[9] = 1 if t[1] > t[2] else 9000000000000000000
    t[10] = 3 << 40
    m[0] = float(t[1] - t[2]) / 1e9
    m[1] = struct.unpack(">f", bytes(b[:4]))[0]
    m[2] = struct.unpack("<f", struct.pack("<f", m[3]))[0]
    b[4], b[5] = t[1] & 255, (t[1] >> 8) & 255
    for i in range(b[6] & 3):
        m[4] += float(i) + float(t[1])


@pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
def test_c_computes_with_64_bits_and_bytes_as_python(tmp_path: Path) -> None:
    program = translate(textwrap.dedent(TEXT), {"entry": (MEMORY, LONGS, BYTES)})
    host.build(program.text(), tmp_path / "w.so", (*(f for f in host.FLAGS if f != "-w"), *STRICT))
    function = host.load(tmp_path / "w.so").vg_entry
    function.argtypes, function.restype = [ctypes.c_void_p] * 3, None
    rng = random.Random(5)  # noqa: S311 (numbers to compute with)
    for _ in range(300):
        b = [rng.randrange(256) for _ in range(8)]
        t = [rng.randrange(-(10**15), 10**15) for _ in range(11)]
        m = [rng.uniform(-1e30, 1e30) for _ in range(5)]
        arrays = np.array(m), np.array(t, dtype=np.int64), np.array(b, dtype=np.uint8)
        expected(m, t, b)
        function(*(array.ctypes.data for array in arrays))
        assert arrays[1].tolist() == t
        assert arrays[2].tolist() == b
        np.testing.assert_array_equal(arrays[0], m)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("m[0] = t[0]", "holds double"),
        ("m[0] = m[1] * t[0]", "mixes a real number"),
        ("t[0] = m[0]", "holds int64_t"),
        ("m[0] = 1.0 if m[0] < t[0] else 0.0", "compares a real number"),
        ("b[0] = m[0]", "gets double"),
        ("m[0] = max(m[0], t[0])", "mixes a real number"),
        ("t[0] = t[0] & m[0]", "mixes a real number"),
    ],
)
def test_what_c_would_round_in_silence_is_refused(line: str, reason: str) -> None:
    with pytest.raises(UntranslatableError, match=reason):
        translate(f"def entry(m, t, b):\n    {line}\n", {"entry": (MEMORY, LONGS, BYTES)})


def test_singles_are_those_of_the_standard_library() -> None:
    for value in (0.0, -0.0, 1.0, -3.25, 1e-45, 3.4028234663852886e38, math.inf, 0.1):
        (bits,) = struct.unpack("<I", struct.pack("<f", value))
        assert int(bits_of_real(value)) == bits
        assert real_of_bits(bits) == struct.unpack("<f", struct.pack("<f", value))[0]
    assert math.isnan(real_of_bits(0x7FC00000))
