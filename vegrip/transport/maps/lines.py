"""Lines of text with whole numbers in them, as packets. Pure.

::

    [packets.position]
    text = "POS {place}"                     # an answer, or a command; each number is a field

The fields are signed numbers of 32 bits, one behind another, so that a line is a packet like others.
"""

import re
import struct
from collections.abc import Mapping
from typing import Any, Final

from vegrip.errors import ConfigError

NUMBER: Final = re.compile(r"\{(\w+)\}")
NEWLINE: Final = "\n"
DIGITS: Final = r" *(-?\d{1,9})"  # nine digits fit into 32 bits


class Line:
    """A line of a form, in bytes as it is sent and as fields."""

    def __init__(self, text: str) -> None:
        parts = NUMBER.split(text)
        self.names = parts[1::2]
        self._text = text + NEWLINE
        self._form = struct.Struct(f">{len(self.names)}i")
        literal = DIGITS.join(re.escape(part) for part in parts[::2])
        self._pattern = re.compile(literal.encode("latin-1") + rb"\s*")

    def fields(self, line: bytes) -> bytes | None:
        """Return the numbers of ``line``; None: it is no such line."""
        match = self._pattern.fullmatch(line)
        return None if match is None else self._form.pack(*map(int, match.groups()))

    def line(self, fields: bytes) -> bytes:
        numbers = dict(zip(self.names, self._form.unpack(fields), strict=True))
        return self._text.format(**numbers).encode("latin-1")


def with_line(keys: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return the keys of a packet of text with its start, end, length and fields.

    >>> with_line({"text": "POS {place}"}, "hand.toml [packets.position]")["fields"]
    {'place': 'i32 be @0'}
    """
    text = str(keys["text"])
    head, *rest = NUMBER.split(text)
    names = rest[::2]
    literal = "".join([head, *rest[1::2]])
    if {"{", "}"} & set(literal) or not all(map(str.isidentifier, names)) or len(set(names)) < len(names):
        raise ConfigError(f"{where}: 'text' is {text!r}; its numbers are {{name}}, each of another name")
    if max(text, default="") > "\xff":
        raise ConfigError(f"{where}: 'text' is {text!r}; its characters must be those of Latin-1")
    fields = {name: f"i32 be @{4 * number}" for number, name in enumerate(names)}
    given = {"start": head.encode("latin-1").hex(" "), "end": "0A", "length": "end", "fields": fields}
    return {**given, **keys}
