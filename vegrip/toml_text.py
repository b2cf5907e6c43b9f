"""Values as TOML text that reads back as the same value, bit for bit."""

import datetime
import json
from collections.abc import Mapping
from typing import Any


def toml_value(value: Any) -> str:
    """Return ``value`` as TOML: text, number, truth, date, or a list or table of them.

    Raises:
        TypeError: TOML has no such value.

    """
    match value:
        case str():
            # JSON's strings are TOML's, but for DEL, which TOML wants escaped
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        case bool():
            return "true" if value else "false"
        case int() | float():  # the shortest text that reads back as the same number
            return repr(float(value)) if isinstance(value, float) else repr(int(value))
        case datetime.date() | datetime.time():
            return value.isoformat()
        case Mapping():
            return "{" + ", ".join(f"{toml_value(k)} = {toml_value(v)}" for k, v in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(map(toml_value, value)) + "]"
    raise TypeError(f"TOML has no {type(value).__name__}: {value!r}")
