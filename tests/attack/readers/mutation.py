"""Ways to break a file: its bytes, its text, its numbers and names. Each follows from its generator."""

import random
import re
from collections.abc import Callable

NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]{2,}")
HOSTILE_NUMBERS = (
    *(
        b"nan",
        b"inf",
        b"-inf",
        b"1e999",
        b"-1e308",
        b"1e-320",
        b"-0.0",
        b"0",
        b"-1",
        b"1",
        b"1_0",
        b"0x10",
        b"",
    ),
    *(b"9223372036854775808", b"-9223372036854775809", b"18446744073709551616", b"1e30", b"2147483648"),
    *(b"9" * 400, b"9" * 5000, b"1." + b"0" * 5000, b"true", b'"1"', b"[1]", b"{}"),
)
HOSTILE_WORDS = (
    *(b"../../x", b"/tmp/vegrip-attack", b"..", b".", b"", b"~", b"C:x", b"a/b", b"con", b"[red]x[/]", b":b"),
    *(
        b"\x00",
        b"a\x00b",
        b"\xff\xfe",
        b"\xed\xa0\x80",
        b"\x1b[31m",
        "ü🤖".encode(),
        b"x" * 300,
        b"x" * 70_000,
    ),
    *(b"__class__", b"{finger}", b"%s%n", b"os:system", b"__proto__"),
)
OPENERS = (b"[" * 3000, b"{a=" * 3000, b"(" * 3000, b'"', b"'''", b"#" * 3000, b"\n" * 3000, b"," * 3000)


def flip_bits(data: bytes, pick: random.Random) -> bytes:
    """Turn up to eight bits."""
    found = bytearray(data)
    for _ in range(pick.randint(1, 8)):
        if found:
            found[pick.randrange(len(found))] ^= 1 << pick.randrange(8)
    return bytes(found)


def cut(data: bytes, pick: random.Random) -> bytes:
    """Keep the beginning, or the end."""
    at = pick.randint(0, len(data))
    return data[:at] if pick.random() < 0.8 else data[at:]


def remove(data: bytes, pick: random.Random) -> bytes:
    """Take a piece out."""
    low, high = sorted(pick.randint(0, len(data)) for _ in range(2))
    return data[:low] + data[high:]


def repeat(data: bytes, pick: random.Random) -> bytes:
    """Repeat a piece, sometimes many times."""
    low, high = sorted(pick.randint(0, len(data)) for _ in range(2))
    times = pick.choice((2, 2, 10, 100))
    return data[:low] + data[low:high] * min(times, 1 + 400_000 // max(high - low, 1)) + data[high:]


def swap(data: bytes, pick: random.Random) -> bytes:
    """Let two pieces change places."""
    a, b, c, d = sorted(pick.randint(0, len(data)) for _ in range(4))
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def overwrite(data: bytes, pick: random.Random) -> bytes:
    """Put chance, zeros, ones or large counts in the place of some bytes."""
    at, length = pick.randint(0, len(data)), pick.choice((1, 2, 4, 8, 64))
    new = pick.choice(
        (pick.randbytes(length), bytes(length), b"\xff" * length, b"\x7f" + b"\xff" * (length - 1))
    )
    return data[:at] + new + data[at + length :]


def insert(data: bytes, pick: random.Random) -> bytes:
    """Put something hostile in between."""
    at = pick.randint(0, len(data))
    return data[:at] + pick.choice((*HOSTILE_WORDS, *HOSTILE_NUMBERS, *OPENERS)) + data[at:]


def renumber(data: bytes, pick: random.Random) -> bytes:
    """Put a hostile number in the place of one, or of several."""
    return _substituted(data, pick, NUMBER, HOSTILE_NUMBERS)


def rename(data: bytes, pick: random.Random) -> bytes:
    """Put a hostile name, or another one of the file, in the place of a name."""
    return _substituted(data, pick, WORD, (*HOSTILE_WORDS, *WORD.findall(data)[:50]))


def shuffle_lines(data: bytes, pick: random.Random) -> bytes:
    """Bring the lines out of order, leave one out, repeat one, join two."""
    lines = data.split(b"\n")
    what, at = pick.randrange(4), pick.randrange(len(lines))
    if what == 0:
        pick.shuffle(lines)
    elif what == 1:
        del lines[at]
    elif what == 2:
        lines.insert(at, lines[pick.randrange(len(lines))])
    elif at + 1 < len(lines):
        lines[at : at + 2] = [lines[at] + lines[at + 1]]
    return b"\n".join(lines)


def _substituted(data: bytes, pick: random.Random, what: re.Pattern[bytes], by: tuple[bytes, ...]) -> bytes:
    found = list(what.finditer(data))
    for match in sorted(
        pick.sample(found, min(len(found), pick.choice((1, 1, 1, 3)))), key=_start, reverse=True
    ):
        data = data[: match.start()] + pick.choice(by) + data[match.end() :]
    return data


def _start(match: re.Match[bytes]) -> int:
    return match.start()


Mutation = Callable[[bytes, random.Random], bytes]
OF_BYTES: tuple[Mutation, ...] = (flip_bits, cut, remove, repeat, swap, overwrite, insert)
OF_TEXT: tuple[Mutation, ...] = (*OF_BYTES, renumber, renumber, renumber, rename, rename, shuffle_lines)


def mutated(data: bytes, pick: random.Random) -> bytes:
    """Return ``data`` broken in one to three ways."""
    ways = OF_TEXT if is_text(data) else OF_BYTES
    for _ in range(pick.choice((1, 1, 2, 3))):
        data = pick.choice(ways)(data, pick)
    return data


def is_text(data: bytes) -> bool:
    """Whether ``data`` reads as text."""
    try:
        return "\0" not in data.decode()
    except UnicodeDecodeError:
        return False
