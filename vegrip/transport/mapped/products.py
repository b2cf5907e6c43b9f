"""The maps in the box: products whose bytes are public, one file each in ``maps``."""

from pathlib import Path
from typing import Any, Final

from vegrip.config import read_toml
from vegrip.errors import InputError, suggestion
from vegrip.transport.mapped.schema import ALL, POLAR, UNKNOWN

FOLDER: Final = Path(__file__).parent / "maps"


def names() -> list[str]:
    """Return the names of all products, as in ``vegrip connect --hand NAME``."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def map_of(name: str) -> Path:
    """Return the path of the map of ``name``.

    Raises:
        InputError: there is none; names the nearest.

    """
    if name not in names():
        raise InputError(f"there is no map of {name!r}; {suggestion(name, names(), 'there are')}")
    return FOLDER / f"{name}.toml"


def about(name: str) -> dict[str, Any]:
    """Return what is known of a product, for ``vegrip connect --list``."""
    table = read_toml(map_of(name))
    product, keys = table["product"], table["fingers"][ALL]
    channels = set(keys) - {"command", "taxels"} - POLAR
    channels |= {"normal_force"} if "taxels" in keys else set()
    channels |= {"tangential_force_x", "tangential_force_y"} if set(keys) >= POLAR else set()
    return {
        "hand": name,
        "name": product["name"],
        "carrier": table["transport"]["kind"] + (" fd" if table["transport"].get("fd") else ""),
        "fingers": [finger for finger in table["fingers"] if finger != ALL],
        "channels": sorted(channels),
        "commands": keys.get("command", {}).get("kind", ""),
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
    }
