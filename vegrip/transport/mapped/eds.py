"""The EDS of a CANopen hand -> a database: its PDO mapping says which objects lie in which frames.

Each finger is a node. The frames of a finger are called ``<finger>_TPDO1`` .. and ``<finger>_RPDO1`` ..,
their signals as the objects are in the EDS.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from vegrip.errors import ConfigError
from vegrip.transport.mapped.database import Database, ForeignMessage, Signal

PDOS: Final = {
    "TPDO": (0x1800, 0x1A00, (0x180, 0x280, 0x380, 0x480)),
    "RPDO": (0x1400, 0x1600, (0x200, 0x300, 0x400, 0x500)),
}
SIGNED: Final = (0x02, 0x03, 0x04, 0x15, 0x10)
FLOATS: Final = (0x08, 0x11)
START: Final = 1
UNUSED: Final = 1 << 31
"""Bit of a COB-ID that says: this PDO is not there."""


def read_eds(path: Path, nodes: Mapping[str, int]) -> Database:
    """Return the frames of the ``nodes``, all of which are what the EDS at ``path`` says.

    Raises:
        ConfigError: no such file, no EDS, no node, or a mapping that cannot be.

    """
    import canopen  # noqa: PLC0415 (only for a CANopen hand)

    if not nodes:
        raise ConfigError(
            f"{path}: the map does not say which node is which finger; add nodes = {{ thumb = 32, ... }}"
        )
    messages: dict[str, ForeignMessage] = {}
    for finger, node in nodes.items():
        if not 1 <= node <= 127:
            raise ConfigError(f"{path}: the node-ID of {finger} is {node}; it must lie in 1 .. 127")
        try:
            with path.open() as text:
                objects: Any = canopen.import_od(text, node_id=node)
        except FileNotFoundError:
            raise ConfigError(f"{path}: there is no such file; 'database' is relative to the map") from None
        except Exception as error:  # noqa: BLE001 (the parser has errors of its own)
            raise ConfigError(
                f"{path}: cannot be read as an EDS ({str(error)[:200] or type(error).__name__})"
            ) from None
        for kind in PDOS:
            for message in _messages(objects, kind, finger, node, path):
                messages[message.name] = message
    if not messages:
        raise ConfigError(
            f"{path}: maps no object into a PDO; ask the maker for the EDS with the PDO mapping of "
            "the delivered hand"
        )
    opening = tuple((0, bytes((START, node))) for node in nodes.values())
    return Database(path.name, messages, opening)


def _messages(objects: Any, kind: str, finger: str, node: int, path: Path) -> list[ForeignMessage]:
    communication, mapping, usual = PDOS[kind]
    found = []
    for number in range(512):
        if mapping + number not in objects:
            continue
        signals = _signals(objects, mapping + number, path)
        identifier = _identifier(objects, communication + number, usual[number] + node if number < 4 else 0)
        if signals and identifier is not None:
            bits = max(signal.start + signal.length for signal in signals.values())
            if bits > 64:
                raise ConfigError(f"{path}: {kind}{number + 1} maps {bits} bits; a frame has 64")
            name = f"{finger}_{kind}{number + 1}"
            found.append(ForeignMessage(name, identifier, (bits + 7) // 8, False, signals))
    return found


def _identifier(objects: Any, index: int, usual: int) -> int | None:
    if index not in objects or 1 not in objects[index]:
        return usual or None
    entry = objects[index][1]
    value = entry.value if entry.value is not None else entry.default
    if value is None:
        return usual or None
    return None if int(value) & UNUSED else int(value) & 0x7FF


def _signals(objects: Any, index: int, path: Path) -> dict[str, Signal]:
    signals: dict[str, Signal] = {}
    start = 0
    count = _value(objects[index][0])
    for sub in range(1, count + 1):
        if sub not in objects[index]:
            break
        word = _value(objects[index][sub])
        main, part, length = word >> 16, word >> 8 & 0xFF, word & 0xFF
        if not word:
            break
        if main >= 0x20:  # below stand the dummies, which only fill
            name, variable = _variable(objects, main, part, path)
            signals[_unique(name, signals)] = Signal(
                _unique(name, signals),
                start,
                length,
                signed=variable.data_type in SIGNED,
                is_float=variable.data_type in FLOATS,
                scale=float(getattr(variable, "factor", 1) or 1),
                unit=str(getattr(variable, "unit", "") or ""),
            )
        start += length
    return signals


def _variable(objects: Any, main: int, part: int, path: Path) -> tuple[str, Any]:
    try:
        entry = objects[main]
        if hasattr(entry, "data_type"):
            return _plain(entry.name), entry
        return _plain(f"{entry.name}_{entry[part].name}"), entry[part]
    except KeyError:
        raise ConfigError(
            f"{path}: the object {main:04X}:{part:02X} is mapped into a PDO and not described"
        ) from None


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name).strip("_")


def _unique(name: str, taken: Mapping[str, Signal]) -> str:
    return name if name not in taken else f"{name}_{len(taken)}"


def _value(entry: Any) -> int:
    value = entry.value if entry.value is not None else entry.default
    return int(value or 0)
