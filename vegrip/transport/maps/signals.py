"""Signals and messages of another maker, whatever names them: a database, packets, an object dictionary."""

import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from vegrip.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Signal:
    """Some bits of a message.

    Attributes:
        start: where it begins, counted as in a DBC: the lowest bit when little-endian, else the highest.
        scale, offset: physical value = raw * scale + offset, in ``unit``.
        low, high: physical limits as declared, NaN where none are.
        selected_by: the multiplexer and its values for which this signal is there; "" = always.

    """

    name: str
    start: int
    length: int
    is_big_endian: bool = False
    is_signed: bool = False
    is_float: bool = False
    scale: float = 1.0
    offset: float = 0.0
    unit: str = ""
    low: float = float("nan")
    high: float = float("nan")
    choices: Mapping[int, str] = field(default_factory=dict)
    selected_by: str = ""
    selectors: Sequence[int] = ()

    @property
    def end(self) -> int:
        """The bytes of a message that it needs."""
        first = 8 * (self.start // 8) + 7 - self.start % 8 if self.is_big_endian else self.start
        return (first + self.length + 7) // 8

    @property
    def invalid(self) -> tuple[int, ...]:
        """The raw values whose names say that nothing is measured."""
        return tuple(raw for raw, name in self.choices.items() if says_nothing(name))

    @property
    def bounds(self) -> tuple[float, float] | None:
        """The raw values of the declared range; None where it has all, or none is declared."""
        if not self.low < self.high or not self.scale:
            return None
        ends = ((each - self.offset) / self.scale for each in (self.low, self.high))
        low, high = sorted(ends)
        if self.is_float:
            return low, high
        low, high = math.floor(low + 0.5), math.ceil(high - 0.5)
        least, largest = self.raw_range
        return None if low <= least and high >= largest else (low, high)

    def shift(self, length: int) -> int:
        """Return by how many bits a message of ``length`` bytes, read as one number, is moved right."""
        if not self.is_big_endian:
            return self.start
        return 8 * length - (8 * (self.start // 8) + 7 - self.start % 8) - self.length

    @property
    def raw_range(self) -> tuple[int, int]:
        """The smallest and the largest raw value of an integer."""
        if self.is_signed:
            return -(1 << self.length - 1), (1 << self.length - 1) - 1
        return 0, (1 << self.length) - 1


NOTHING: Final = re.compile(
    r"(^|_)(sna|n_?a|not_?(avail|valid|ready|meas|used)|unavail|invalid|err(or)?(_|$)|fault|fail|init|undef"
    r"|unknown|no_?(data|value|signal|meas)|fehler|ungueltig|nicht_?(verf|gueltig|bereit)|out_?of_?range"
    r"|over_?(range|flow)|under_?(range|flow)|broken|reserv|defe[ck]t|unbekannt|gestoert|stoerung)",
)
"""What names of raw values say that are no measurement."""
UMLAUTS: Final = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"})


def folded(name: str) -> str:
    """Return ``name`` in letters without accents.

    >>> folded("Kraft_längs_é")
    'Kraft_laengs_e'
    """
    plain = unicodedata.normalize("NFC", name).translate(UMLAUTS)
    return "".join(c for c in unicodedata.normalize("NFKD", plain) if not unicodedata.combining(c))


def says_nothing(name: str) -> bool:
    """Whether ``name``, of a raw value, says that nothing is measured.

    >>> [says_nothing(name) for name in ("SignalNotAvailable", "SNA", "Init", "No slip", "Terror")]
    [True, True, True, False, False]
    """
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", folded(name))
    return NOTHING.search(re.sub(r"[\W_]+", "_", words).lower()) is not None


@dataclass(frozen=True, slots=True)
class ForeignMessage:
    """One kind of frame."""

    name: str
    identifier: int
    length: int  # [bytes]
    fd: bool
    signals: Mapping[str, Signal]
    asked: bool = False  # comes as the answer to a request (CANopen SDO)
    checked: bool = False  # its checksum is looked at before it comes here
    template: bytes = b""  # what stands in it whatever it carries
    has_validity: bool = False  # says itself whether its values are valid


def expanded(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return ``names`` with each ``{first..last}`` written out.

    >>> expanded(("Pad.T{1..3}", "Pad.Sum"))
    ('Pad.T1', 'Pad.T2', 'Pad.T3', 'Pad.Sum')
    """
    found: list[str] = []
    for name in names:
        head, brace, rest = name.partition("{")
        span, closed, tail = rest.partition("}")
        first, dots, last = span.partition("..")
        if not (brace and closed and dots and first.isdecimal() and last.isdecimal()):
            found.append(name)
            continue
        if not int(first) <= int(last) <= int(first) + 1023:
            raise ConfigError(f"{name!r} must count upwards, and over 1024 signals at most")
        found += [f"{head}{number}{tail}" for number in range(int(first), int(last) + 1)]
    return tuple(found)
