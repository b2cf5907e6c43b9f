"""The object dictionaries of both devices, out of the DBC and the declarations of the parameters."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from cantools.database.can import Message, Signal

from vegrip.canopen.network import (
    COMMANDS,
    CONSUMED,
    ESTIMATED,
    ESTIMATES,
    FIRST_FINGER,
    HEALTH,
    MARGINS,
    OF_A_FINGER,
    OF_THE_GRASP,
    PARAMETERS,
    REFUSAL,
    STATES,
    STATUS,
    TIME_COB_ID,
)
from vegrip.grip.parameters import GraspParameters
from vegrip.runtime.lifecycle import rows
from vegrip.transport.codec.database import database, layouts

BOOLEAN, INTEGER8, INTEGER16, INTEGER32 = 0x01, 0x02, 0x03, 0x04
UNSIGNED8, UNSIGNED16, UNSIGNED32, REAL32 = 0x05, 0x06, 0x07, 0x08
VISIBLE_STRING, UNSIGNED48 = 0x09, 0x19
BITS: Final = {
    BOOLEAN: 8,
    INTEGER8: 8,
    INTEGER16: 16,
    INTEGER32: 32,
    UNSIGNED8: 8,
    UNSIGNED16: 16,
    UNSIGNED32: 32,
    REAL32: 32,
    UNSIGNED48: 48,
}
"""Length of each data type in a PDO."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One value that can be read or written."""

    name: str
    data_type: int
    access: str = "ro"  # ro, rw, const
    default: str = ""  # as it stands in the file
    is_mappable: bool = False
    note: str = ""  # unit and meaning; goes into a comment


@dataclass(frozen=True, slots=True)
class Variable:
    """An object that is one value."""

    index: int
    entry: Entry


@dataclass(frozen=True, slots=True)
class Record:
    """An object of several values; entries are numbered from sub-index 1."""

    index: int
    name: str
    entries: tuple[Entry, ...]
    is_array: bool = False


Object = Variable | Record


@dataclass(frozen=True, slots=True)
class Pdo:
    """A process data object: one CAN frame of mapped entries."""

    number: int  # from 0
    is_transmitted: bool
    cob_id: str  # as it stands in the file
    transmission_type: int
    mapped: tuple[tuple[int, int, int], ...]  # index, sub-index, bits


@dataclass(frozen=True, slots=True)
class Device:
    """Everything an EDS file says."""

    file: str
    product: str
    product_number: int
    description: str
    objects: tuple[Object, ...]
    pdos: tuple[Pdo, ...]
    comments: tuple[str, ...] = field(default=())


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


MAX_FINGERS: Final = 8
NO_RTR: Final = 0x4000_0000
EVENT_DRIVEN = 254
HEARTBEAT_TIME, HEARTBEAT_LIMIT = 200, 500  # [ms]


TYPE_OF: Final = {bool: BOOLEAN, int: INTEGER32, float: REAL32, str: VISIBLE_STRING}


def fingertip() -> Device:
    """Return what ``proto/fingertip.eds`` says: a sensor, and the drive behind it."""
    states = [pdo_record(0x2000 + i, f"State {i + 1}", f"FingertipState{i + 1}") for i in range(3)]
    inputs = [
        pdo_record(0x2010 + i, name, name)
        for i, name in enumerate(("ForceCommand", "SlipMargin", "ModelHealth"))
    ]
    out = [
        Pdo(i, True, own(OF_A_FINGER[f"FingertipState{i + 1}"]), EVENT_DRIVEN, pdo_mapping(record))
        for i, record in enumerate(states)
    ]
    into = [
        Pdo(i, False, own(OF_A_FINGER[record.name]), EVENT_DRIVEN, pdo_mapping(record))
        for i, record in enumerate(inputs)
    ]
    return Device(
        "fingertip.eds",
        "vegrip fingertip",
        1,
        "Fingertip sensor: forces, torque, displacement, slip; takes force commands",
        (*common("vegrip fingertip", 1), *states, *inputs),
        (*out, *into),
        ("The PDOs are the classic frames of fingertip.dbc, byte for byte.",),
    )


def grasp_force(known: Mapping[str, int]) -> Device:
    """Return what ``proto/grasp_force.eds`` says: up to eight fingers, all parameters, all estimates.

    Args:
        known: the parameters that have an index already, as in :func:`known_parameters`.

    """
    told = (("ForceCommand", COMMANDS), ("SlipMargin", MARGINS), ("ModelHealth", HEALTH))
    outputs = [
        pdo_record(index + finger, f"{name} {finger}", name)
        for name, index in told
        for finger in range(MAX_FINGERS)
    ]
    out = [
        Pdo(
            n,
            True,
            f"{NO_RTR + OF_A_FINGER[record.name[:-2]] + FIRST_FINGER + n % MAX_FINGERS:#x}",
            254,
            pdo_mapping(record),
        )
        for n, record in enumerate(outputs)
    ]
    status = pdo_record(STATUS, "NodeStatus", "NodeStatus")
    out.append(Pdo(len(out), True, own(OF_THE_GRASP["NodeStatus"]), EVENT_DRIVEN, pdo_mapping(status)))
    states = [
        pdo_record(
            STATES + 3 * finger + part, f"State {part + 1} of finger {finger}", f"FingertipState{part + 1}"
        )
        for finger in range(MAX_FINGERS)
        for part in range(3)
    ]
    into = [
        Pdo(
            n,
            False,
            f"{0x180 + 0x100 * (n % 3) + FIRST_FINGER + n // 3:#x}",
            EVENT_DRIVEN,
            pdo_mapping(record),
        )
        for n, record in enumerate(states)
    ]
    return Device(
        "grasp_force.eds",
        "vegrip grasp force",
        2,
        "Grasp force node: fingertip states in, force commands and slip margins out",
        (
            *common("vegrip grasp force", 2),
            *_supervision(),
            *outputs,
            status,
            *states,
            *(_estimates(finger) for finger in range(MAX_FINGERS)),
            Variable(
                REFUSAL, Entry("Last refusal", VISIBLE_STRING, "ro", "", note="why a write was refused")
            ),
            *_parameters(known),
        ),
        (*out, *into),
        ("The PDOs are the classic frames of fingertip.dbc, byte for byte.",),
    )


def known_parameters(text: str) -> dict[str, int]:
    """Return name -> index of the parameters in the text of an EDS file: what others rely on must stay."""
    found = re.findall(r"^\[([345][0-9A-F]{3})\]\nParameterName=(.+)$", text, re.MULTILINE)
    return {name: int(index, 16) for index, name in found}


def own(base: int) -> str:
    return f"$NODEID+{NO_RTR + base:#x}"


def common(name: str, product: int) -> tuple[Object, ...]:
    """Return the objects every device here has."""
    version = layouts().version
    identity = (
        Entry("Vendor-ID", UNSIGNED32, "ro", "0x0", note="none assigned"),
        Entry("Product code", UNSIGNED32, "ro", f"{product:#x}"),
        Entry("Revision number", UNSIGNED32, "ro", f"{version << 16:#x}", note="version of the message set"),
        Entry("Serial number", UNSIGNED32, "ro", "0x0"),
    )
    server = (
        Entry("COB-ID client to server", UNSIGNED32, "ro", "$NODEID+0x600"),
        Entry("COB-ID server to client", UNSIGNED32, "ro", "$NODEID+0x580"),
    )
    return (
        Variable(0x1000, Entry("Device type", UNSIGNED32, "ro", "0x0", note="no device profile")),
        Variable(0x1001, Entry("Error register", UNSIGNED8, "ro", "0x0", is_mappable=True)),
        Record(0x1018, "Identity object", identity),
        Variable(0x1005, Entry("COB-ID SYNC", UNSIGNED32, "rw", "0x80")),
        Variable(0x1008, Entry("Manufacturer device name", VISIBLE_STRING, "const", name)),
        Variable(0x1012, Entry("COB-ID time stamp object", UNSIGNED32, "ro", f"{CONSUMED | TIME_COB_ID:#x}")),
        Variable(0x1014, Entry("COB-ID EMCY", UNSIGNED32, "ro", "$NODEID+0x80")),
        Variable(0x1017, Entry("Producer heartbeat time", UNSIGNED16, "rw", str(HEARTBEAT_TIME), note="ms")),
        Record(0x1200, "SDO server parameter", server),
    )


def _supervision() -> tuple[Object, ...]:
    watched = tuple(
        Entry(
            f"Consumer heartbeat time {n}",
            UNSIGNED32,
            "ro",
            f"{(FIRST_FINGER + n) << 16 | HEARTBEAT_LIMIT:#x}",
        )
        for n in range(MAX_FINGERS)
    )
    behaviour = Entry(
        "Communication error", UNSIGNED8, "rw", "0x1", note="0: pre-operational, 1: go on, 2: stop"
    )
    return (
        Variable(0x1006, Entry("Communication cycle period", UNSIGNED32, "ro", "0", note="us, of SYNC")),
        Record(0x1016, "Consumer heartbeat time", watched, is_array=True),
        Record(0x1029, "Error behaviour", (behaviour,), is_array=True),
    )


def _estimates(finger: int) -> Record:
    entries = [Entry(f"{name}{suffix}", REAL32, "ro", "0.0") for name in ESTIMATED for suffix in ("", "_std")]
    return Record(ESTIMATES + finger, f"Estimate of finger {finger}", tuple(entries))


def _parameters(known: Mapping[str, int]) -> Iterator[Variable]:
    """Yield one object for each parameter; one that has an index keeps it, a new one gets the next."""
    following = max(known.values(), default=PARAMETERS - 1) + 1
    for name, value, declared in rows(GraspParameters()):
        kind = TYPE_OF.get(type(value))
        if kind is None:
            continue  # pairs and tables belong in the configuration file
        index = known.get(name, following)
        following += index == following
        yield Variable(index, Entry(name, kind, "rw", note=_note(declared)))


def _note(declared: Any) -> str:
    parts = [declared.unit, declared.doc, "" if declared.live else "only while unconfigured"]
    return "; ".join(part for part in parts if part)
