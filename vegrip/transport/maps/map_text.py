"""The text of a map: keys are set in it without another line changing, and others come from the box."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from vegrip.config import merged, parse_toml, read_toml, toml_key, toml_value
from vegrip.errors import ConfigError, InputError, suggestion

FOLDER: Final = Path(__file__).parent / "box"

Setting = tuple[list[str], Any]
"""Path of a key, and what is set there."""


def key_line(key: str, value: Any, note: str) -> str:
    text = f"{toml_key(key)} = {toml_value(value)}"
    return f"{text:<44} # {note}" if note else text


def changed_text(text: str, settings: Sequence[Setting], by: str = "said by --set") -> str:
    """Return the text of a map with some keys set ``by`` whom; only lines of those tables change."""
    for path, value in settings:
        text = _changed(text, path, value, by)
    return text


def _changed(text: str, path: list[str], value: Any, by: str) -> str:
    *tables, key = path
    lines = text.split("\n")
    header = f"[{'.'.join(toml_key(name) for name in tables)}]" if tables else ""
    line = key_line(key, value, by)
    inline = f"{toml_key(key)} ="
    nested = f"[{'.'.join(toml_key(name) for name in path)}]"
    if nested in lines:  # a table is replaced by what was said of it
        first = lines.index(nested)
        last = next(
            (n for n in range(first + 1, len(lines)) if lines[n].startswith("[") or not lines[n]), len(lines)
        )
        del lines[first:last]
    if header and header not in lines:
        return "\n".join([*lines, header, line, ""])
    first = lines.index(header) + 1 if header else 0
    last = next((n for n in range(first, len(lines)) if lines[n].startswith("[")), len(lines))
    for number in range(first, last):
        if lines[number].startswith(inline):
            lines[number] = line
            return "\n".join(lines)
    if not header:
        first = next((n for n, each in enumerate(lines) if each.startswith("database")), 0)
    lines.insert(first, line)
    return "\n".join(lines)


def surely_changed(text: str, settings: Sequence[Setting], where: str, by: str = "said by --set") -> str:
    """Return the text of a map with some keys set as by :func:`changed_text`, and read back.

    Raises:
        InputError: the map has no lines for them; says what to write by hand.

    """
    changed = changed_text(text, settings, by)
    last = {tuple(path): value for path, value in settings}
    try:
        table = parse_toml(changed)
        done = all(_at(table, path) == value for path, value in last.items())
    except (ValueError, KeyError, TypeError):
        done = False
    if not done:
        wanted = ", ".join(f"{'.'.join(path)} = {toml_value(value)}" for path, value in last.items())
        raise InputError(f"{where}: has no lines of their own for what was {by}; write: {wanted}")
    return changed


def _at(table: Any, path: Sequence[str]) -> Any:
    for key in path:
        table = table[key]
    return table


def whole(table: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """Return a map with all that it does not say from the product that it is ``like``."""
    if "like" not in table:
        return table
    known = sorted(path.stem for path in FOLDER.glob("*.toml"))
    if (name := table["like"]) not in known:
        raise ConfigError(f"{where}: 'like' is {name!r}; {suggestion(str(name), known, 'there are')}")
    return merged(whole(read_toml(FOLDER / f"{name}.toml"), name), table)
