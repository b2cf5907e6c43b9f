"""Values on the command line, written as in TOML; what is no TOML is text."""

import math
from typing import Any

from vegrip.config import parse_toml
from vegrip.errors import UsageError


def parsed(text: str) -> Any:
    """Return the value of ``text``: 0.4, 3, true, [1, 2], "text" or text."""
    try:
        return parse_toml(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def assigned(table: dict[str, Any], assignment: str) -> None:
    """Carry out ``dotted.key=value`` in ``table``.

    Raises:
        UsageError: it is no assignment, or its key runs through a value.

    """
    key, equals, value = assignment.partition("=")
    if not (equals and key):
        raise UsageError(f"{assignment!r} is no assignment; write --set transport.channel=can1")
    *groups, last = key.split(".")
    for group in groups:
        table = table.setdefault(group, {})
        if not isinstance(table, dict):
            raise UsageError(f"{group!r} in {key!r} is a value, not a table")
    table[last] = parsed(value)


def jsonable(value: Any) -> Any:
    """Return ``value`` as JSON can carry it: NaN as None, infinity and members of enumerations as text."""
    if isinstance(value, dict):
        return {key: jsonable(item) for key, item in value.items()}
    if isinstance(value, float) and math.isnan(value):
        return None
    if isinstance(value, float) and math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return getattr(value, "name", value)
