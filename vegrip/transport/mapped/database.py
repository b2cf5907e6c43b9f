"""Messages and signals of a foreign hand, and their declaration in a DBC, KCD, SYM or ARXML file."""

import math
import re
import unicodedata
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vegrip.errors import ConfigError
from vegrip.text_encoding import decoded
from vegrip.transport.codec.frame import EXTENDED

if TYPE_CHECKING:
    from vegrip.transport.mapped.packets import Packet

__all__ = ["EXTENDED", "Database", "ForeignMessage", "Signal", "expanded"]


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


@dataclass(frozen=True, slots=True)
class Database:
    """All messages of a file, by name."""

    name: str
    messages: Mapping[str, ForeignMessage]
    opening: tuple[tuple[int, bytes], ...] = ()  # frames to send once, before anything comes
    descriptors: bytes = b""  # of protobuf
    packets: tuple["Packet", ...] = ()  # of a device that is on no CAN bus
    left_out: Mapping[int, str] = field(default_factory=dict)  # identifier -> why it is no message here

    def signal(self, name: str) -> Signal:
        """Return the signal MESSAGE.SIGNAL; KeyError: there is none."""
        message, _, signal = name.partition(".")
        return self.messages[message].signals[signal]


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


MAX_DATABASE_BYTES: Final = 4 * 2**20  # [bytes] of a file
MOST_SIGNALS: Final = 20_000  # a hand has some hundreds; cantools reads six thousand a second
DECLARED: Final = re.compile(rb"\bSG_\s+\w+\s*(?:[mM]\w*\s*)?:|<Signal\s|<I-SIGNAL[\s>]|\b(?:Sig|Var)=")
"""What declares a signal in a DBC, KCD, ARXML or SYM file."""


KINDS: Final = {".dbc": "dbc", ".kcd": "kcd", ".sym": "sym", ".arxml": "arxml"}
WIDE: Final = re.compile(r"^BO_[ \t]+(\d+)[ \t]+(\w+)[ \t]*:", re.MULTILINE)
LARGEST_STANDARD: Final = 0x7FF


def read_dbc(path: Path) -> Database:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_DATABASE_BYTES + 1)
        for limit, is_beyond in (
            (f"{MAX_DATABASE_BYTES >> 20} MiB", len(content) > MAX_DATABASE_BYTES),
            (f"{MOST_SIGNALS} signals", sum(1 for _ in DECLARED.finditer(content)) > MOST_SIGNALS),
        ):
            if is_beyond:
                raise ConfigError(f"{path}: has more than {limit}; give the part of it that is the hand")
        database, left_out = _loaded(decoded(content), KINDS.get(path.suffix.lower()))
    except FileNotFoundError:
        raise ConfigError(f"{path}: there is no such file; 'database' is relative to the map") from None
    except ConfigError:
        raise
    except Exception as error:  # noqa: BLE001 (each parser has errors of its own)
        raise ConfigError(f"{path}: cannot be read as a CAN database ({_first_line(error)})") from None
    messages = getattr(database, "messages", None)
    if not messages or not hasattr(messages[0], "frame_id"):
        raise ConfigError(f"{path}: declares no CAN message")
    found = [_message(message) for message in messages if message.length and message.frame_id not in left_out]
    found = _named_apart(found)
    return Database(path.name, {message.name: message for message in found}, left_out=left_out)


def _loaded(text: str, kind: str | None) -> tuple[Any, dict[int, str]]:
    """Return the database without the messages that cannot be, and why each of these cannot."""
    import cantools.database  # noqa: PLC0415 (half a second, only where there is a map)

    try:
        return cantools.database.load_string(text, kind, strict=True), {}
    except Exception as error:  # noqa: BLE001 (each parser has errors of its own)
        refusal = error
    left_out: dict[int, str] = {}

    def widened(match: re.Match[str]) -> str:
        number = int(match[1])
        if not LARGEST_STANDARD < number < EXTENDED:
            return match[0]
        left_out[number] = f"{match[2]}: 0x{number:X} has more than 11 bits, and not the mark of 29 bits"
        return match[0].replace(match[1], str(number | EXTENDED), 1)

    text = WIDE.sub(widened, text) if kind in ("dbc", None) else text
    try:
        database: Any = cantools.database.load_string(text, kind, strict=False)
    except Exception:  # noqa: BLE001 (the first complaint is of the file as it is)
        raise refusal from None
    for message in database.messages:
        try:
            message.refresh(strict=True)
        except Exception as error:  # noqa: BLE001
            left_out.setdefault(message.frame_id, f"{message.name}: {_first_line(error)}")
    if all(message.frame_id in left_out for message in database.messages):
        raise refusal
    return database, left_out


def _named_apart(messages: Sequence[ForeignMessage]) -> list[ForeignMessage]:
    """Return ``messages`` with their identifier in the names that stand twice."""
    counts = Counter(message.name for message in messages)
    return [
        replace(one, name=f"{one.name}_{one.identifier & ~EXTENDED:X}") if counts[one.name] > 1 else one
        for one in messages
    ]


def _first_line(error: Exception) -> str:
    return str(error).strip().partition("\n")[0][:200] or type(error).__name__


def _message(message: Any) -> ForeignMessage:
    identifier = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
    fd = bool(message.is_fd) or message.length > 8
    signals = {signal.name: _signal(signal) for signal in message.signals}
    return ForeignMessage(message.name, identifier, message.length, fd, signals)


def _signal(signal: Any) -> Signal:
    return Signal(
        name=signal.name,
        start=signal.start,
        length=signal.length,
        is_big_endian=signal.byte_order == "big_endian",
        is_signed=bool(signal.is_signed),
        is_float=bool(signal.is_float),
        scale=float(signal.scale),
        offset=float(signal.offset),
        unit=signal.unit or "",
        low=math.nan if signal.minimum is None else float(signal.minimum),
        high=math.nan if signal.maximum is None else float(signal.maximum),
        choices={int(raw): str(word) for raw, word in (signal.choices or {}).items()},
        selected_by=signal.multiplexer_signal or "" if signal.multiplexer_ids else "",
        selectors=tuple(signal.multiplexer_ids or ()),
    )
