"""The classic frames of ``proto/fingertip.dbc``, byte for byte, as records of objects mapped into PDOs."""

from cantools.database.can import Message, Signal

from vegrip.canopen.objects import (
    BITS,
    INTEGER8,
    INTEGER16,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED48,
    Entry,
    Record,
)
from vegrip.transport.codec.database import database

HEADER = Entry("header", UNSIGNED16, "rw", "0", is_mappable=True, note="CRC-8, counter, version, flag")
TYPES = {(8, False): UNSIGNED8, (8, True): INTEGER8, (16, False): UNSIGNED16, (16, True): INTEGER16}


def pdo_record(index: int, name: str, message: str) -> Record:
    found = database().get_message_by_name(message)
    return Record(index, name, (HEADER, *_content(found)))


def pdo_mapping(record: Record) -> tuple[tuple[int, int, int], ...]:
    return tuple((record.index, sub, BITS[e.data_type]) for sub, e in enumerate(record.entries, 1))


def _content(message: Message) -> list[Entry]:
    """Return what follows the header; one block of 48 bits when signals do not lie on bytes."""
    signals = sorted((s for s in message.signals if s.start >= 16), key=lambda s: s.start)
    if any(s.start % 8 or (s.length, s.is_signed) not in TYPES for s in signals):
        return [
            Entry(
                "content", UNSIGNED48, "rw", "0", is_mappable=True, note="; ".join(_bits(s) for s in signals)
            )
        ]
    entries = []
    at = 16
    for signal in signals:
        entries += [_reserved(byte) for byte in range(at, signal.start, 8)]
        entries.append(_entry(signal))
        at = signal.start + signal.length
    return entries + [_reserved(byte) for byte in range(at, 64, 8)]


def _entry(signal: Signal) -> Entry:
    kind = TYPES[signal.length, signal.is_signed]
    unit = f"{float(signal.scale):g} {signal.unit or '1'} per bit"
    return Entry(signal.name, kind, "rw", "0", is_mappable=True, note=unit)


def _reserved(bit: int) -> Entry:
    return Entry(f"reserved_{bit // 8}", UNSIGNED8, "rw", "0", is_mappable=True, note="zero")


def _bits(signal: Signal) -> str:
    return f"{signal.name} bits {signal.start - 16}..{signal.start + signal.length - 17}"
