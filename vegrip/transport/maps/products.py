"""The maps in the box: products whose bytes are public, one file each in the folder ``box``."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from vegrip.config import parse_toml, read_toml
from vegrip.errors import ConfigError, InputError, suggestion
from vegrip.transport.maps.map_text import FOLDER, changed_text, whole
from vegrip.transport.maps.schema import ALL, POLAR, REPORTED, UNKNOWN

DRIVE: Final = 0x7E0
"""Identifier of the first command packet that a virtual device without commands is given."""


def names() -> list[str]:
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def map_of(name: str) -> Path:
    """Return the path of the map of ``name``."""
    if name not in names():
        raise InputError(f"there is no map of {name!r}; {suggestion(name, names(), 'there are')}")
    return FOLDER / f"{name}.toml"


def about(name: str) -> dict[str, Any]:
    """Return what is known of a product, for ``vegrip connect --list``."""
    table = whole(read_toml(map_of(name)), name)
    product, keys = table["product"], table["fingers"][ALL]
    channels = set(keys) - {"command", "taxels", *REPORTED} - POLAR
    channels |= {"normal_force"} if "taxels" in keys else set()
    channels |= {"tangential_force_x", "tangential_force_y"} if set(keys) >= POLAR else set()
    return {
        "hand": name,
        "name": product["name"],
        "carrier": table["transport"]["kind"] + (" fd" if table["transport"].get("fd") else ""),
        "fingers": [finger for finger in table["fingers"] if finger != ALL],
        "channels": sorted(channels),
        "commands": keys["command"].get("kind", "force") if "command" in keys else "",
        "source": product["source"],
        "checked_against": product["checked_against"],
        "tried_on": product["tried_on"],
        "to_measure": [
            f"{channel}.{key}"
            for channel, each in keys.items()
            if isinstance(each, dict)
            for key, value in each.items()
            if value == UNKNOWN
        ],
        "reports": [name.removeprefix("device_") for name in REPORTED if name in keys],
    }


def virtual_text(path: Path, *, has_drive: bool = True) -> str:
    """Return the map at ``path`` as its virtual device speaks it.

    What is still to be measured has the values of its ``[product.virtual]``. With ``has_drive`` a sensor
    without commands is given a drive: a packet ``drive_FINGER`` each, with a force in it.
    """
    text = path.read_text(encoding="utf-8")
    table = whole(parse_toml(text), str(path))
    shared = table["fingers"].get(ALL, {})
    said: list[tuple[list[str], Any]] = []
    for name, value in table.get("product", {}).get("virtual", {}).items():
        channel, _, key = name.partition(".")
        if shared.get(channel, {}).get(key) == UNKNOWN:
            said.append((["fingers", ALL, channel, key], value))
    if "database" in table:
        said.append((["database"], str(path.parent.absolute() / table["database"])))
    if has_drive and not any("command" in keys for keys in table["fingers"].values()):
        if "packets" not in table:
            raise ConfigError(f"{path}: no command is mapped, so its virtual device holds nothing")
        said += _drive(table)
    return changed_text(text, said)


def _drive(table: Mapping[str, Any]) -> Iterator[tuple[list[str], Any]]:
    on_can = any("identifier" in packet for packet in table["packets"].values())
    offset = table.get("device", {}).get("offset", 0)
    for number, finger in enumerate(name for name in table["fingers"] if name != ALL):
        packet = ["packets", f"drive_{finger}"]
        first = 0 if on_can else 4
        yield (
            ([*packet, "identifier"], DRIVE + number - offset)
            if on_can
            else ([*packet, "start"], f"D5 F0 4C {number:02X}")
        )
        yield [*packet, "length"], first + 4
        yield [*packet, "fields", "force"], f"f32 le @{first} * 1 N"
    yield ["fingers", ALL, "command", "signal"], "drive_{finger}.force"
