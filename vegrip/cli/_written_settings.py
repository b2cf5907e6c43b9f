"""What was measured of a hand, written into its launch file or its map: parameters of the grip controller."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vegrip.config import parse_toml, toml_value
from vegrip.errors import InputError
from vegrip.whole_file import write_whole, writing

Tables = Mapping[str, Any]


def write_settings(path: Path, section: str, settings: Mapping[str, Any], by: str) -> None:
    """Write ``settings`` as the table ``section`` of the grip controller of a launch file, or of a map.

    Raises:
        InputError: the file cannot be read, or has no place for them; says what to write by hand.

    """
    text, table = _read(path)
    lines = {key: toml_value(value) for key, value in settings.items()}
    if "node" in table:
        text = _in_launch(text, section, lines, by)
    else:
        from vegrip.transport.maps.map_text import changed_text

        text = changed_text(text, [([section, key], value) for key, value in settings.items()])
    if not _is_in(text, section, settings):
        wanted = ", ".join(f"parameters.{section}.{key} = {value}" for key, value in lines.items())
        raise InputError(
            f'{path}: has no node with program = "grasp_force" that can be added to; write into yours: '
            f"{wanted}"
        )
    with writing(path):
        write_whole(path, text)


def written_settings(path: Path, section: str) -> list[Mapping[str, Any]]:
    """Return the tables ``section`` of the grip controllers of a launch file, or that of a map."""
    return _tables(_read(path)[1], section)


def _read(path: Path) -> tuple[str, Mapping[str, Any]]:
    try:
        text = path.read_text(encoding="utf-8")
        return text, parse_toml(text)
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path} cannot be read as a launch file: {error}") from None


def _tables(table: Mapping[str, Any], section: str) -> list[Mapping[str, Any]]:
    given = [one.get("parameters", {}).get(section, {}) for one in table.get("node", [])]
    return [*given, table.get(section, {})]


def _is_in(text: str, section: str, settings: Mapping[str, Any]) -> bool:
    try:
        table = parse_toml(text)
    except (ValueError, RecursionError):  # parameters in braces, or said twice
        return False
    return any(settings.items() <= one.items() for one in _tables(table, section))


def _in_launch(text: str, section: str, values: Mapping[str, str], by: str) -> str:
    lines = text.split("\n")
    program = next(
        (n for n, one in enumerate(lines) if re.match(r"""\s*program\s*=\s*["']grasp_force["']""", one)), None
    )
    if program is None:
        return text
    later = (n for n in range(program, len(lines)) if lines[n].lstrip().startswith("[["))
    end = next(later, len(lines))
    places = (  # a header within the [[node]], and what stands before a key below it
        (f"[node.parameters.{section}]", ""),
        ("[node.parameters]", f"{section}."),
        ("", f"parameters.{section}."),
    )
    for header, prefix in places:
        at = next(
            (n for n in range(program, end) if header and lines[n].split("#")[0].strip() == header), None
        )
        if at is None and header:
            continue
        begin = program if at is None else at
        keys = "|".join(re.escape(prefix + key) for key in values)
        kept = [one for one in lines[begin + 1 : end] if not re.match(rf"\s*({keys})\s*=", one)]
        new = [f"{prefix}{key} = {value} # {by}" for key, value in values.items()]
        return "\n".join([*lines[: begin + 1], *new, *kept, *lines[end:]])
    return text
