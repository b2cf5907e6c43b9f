"""Parameters put into a launch file, or into the map of a hand; every other line stays as it is."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vegrip.config import parse_toml
from vegrip.errors import InputError
from vegrip.whole_file import write_whole

PLACES = (
    ("[node.parameters.friction]", ""),
    ("[node.parameters]", "friction."),
    ("", "parameters.friction."),
)
"""Headers within the [[node]], and what stands before a key of ``friction`` below them."""


def put_friction(path: Path, settings: Mapping[str, Any], by: str) -> None:
    """Write ``settings`` as ``friction`` of the grip controller of a launch file, or of a map.

    Raises:
        InputError: the file cannot be read or written, or has no grip controller.

    """
    from vegrip.toml_text import toml_value
    from vegrip.transport.mapped.writer import changed_text

    try:
        text = path.read_text(encoding="utf-8")
        table = parse_toml(text)
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path} cannot be read as a launch file: {error}") from None
    lines = {key: toml_value(value) for key, value in settings.items()}
    if "node" in table:
        text = _in_launch(text, lines, by)
    else:
        text = changed_text(text, [(["friction", key], value) for key, value in settings.items()])
    if not _is_in(text, settings):
        wanted = ", ".join(f"parameters.friction.{key} = {value}" for key, value in lines.items())
        raise InputError(
            f'{path}: has no node with program = "grasp_force" that can be added to; write into yours: '
            f"{wanted}"
        )
    try:
        write_whole(path, text)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from None


def _is_in(text: str, settings: Mapping[str, Any]) -> bool:
    try:
        table = parse_toml(text)
    except (ValueError, RecursionError):  # parameters in braces, or said twice
        return False
    given = [one.get("parameters", {}).get("friction", {}) for one in table.get("node", [])]
    return any(settings.items() <= one.items() for one in (*given, table.get("friction", {})))


def _in_launch(text: str, values: Mapping[str, str], by: str) -> str:
    lines = text.split("\n")
    program = next(
        (n for n, one in enumerate(lines) if re.match(r"""\s*program\s*=\s*["']grasp_force["']""", one)), None
    )
    if program is None:
        return text
    later = (n for n in range(program, len(lines)) if lines[n].lstrip().startswith("[["))
    end = next(later, len(lines))
    for header, prefix in PLACES:
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
