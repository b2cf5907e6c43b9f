"""Keys and values as TOML text that reads back as the same, bit for bit."""

import datetime
import json
import re
from collections.abc import Mapping
from typing import Any

BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_key(name: str) -> str:
    """Return ``name`` as a key: bare where TOML allows that, else quoted."""
    return name if BARE_KEY.fullmatch(name) else toml_value(name)


def toml_value(value: Any) -> str:
    """Return ``value`` as TOML on one line: text, number, truth, date, or a list or table of them.

    >>> toml_value({"kind": "crc8", "polynomial": 47, "data_id": [1]})
    '{ kind = "crc8", polynomial = 47, data_id = [1] }'

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
            inner = ", ".join(f"{toml_key(key)} = {toml_value(each)}" for key, each in value.items())
            return f"{{ {inner} }}" if inner else "{}"
        case list() | tuple():
            return "[" + ", ".join(map(toml_value, value)) + "]"
    raise TypeError(f"TOML has no {type(value).__name__}: {value!r}")
