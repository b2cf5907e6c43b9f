"""The messages of a foreign hand, as a DBC, KCD, SYM or ARXML file declares them."""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from vegrip.errors import ConfigError, first_line
from vegrip.text_encoding import decoded
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.maps.packets import Packet
from vegrip.transport.maps.signals import ForeignMessage, Signal


@dataclass(frozen=True, slots=True)
class Database:
    """All messages of a file, by name."""

    name: str
    messages: Mapping[str, ForeignMessage]
    opening: tuple[tuple[int, bytes], ...] = ()  # frames to send once, before anything comes
    descriptors: bytes = b""  # of protobuf
    packets: tuple[Packet, ...] = ()  # of a device that is on no CAN bus
    left_out: Mapping[int, str] = field(default_factory=dict)  # identifier -> why it is no message here

    def signal(self, name: str) -> Signal:
        """Return the signal MESSAGE.SIGNAL; KeyError: there is none."""
        message, _, signal = name.partition(".")
        return self.messages[message].signals[signal]


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
        raise ConfigError(f"{path}: cannot be read as a CAN database ({first_line(error)[:200]})") from None
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
            left_out.setdefault(message.frame_id, f"{message.name}: {first_line(error)[:200]}")
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
