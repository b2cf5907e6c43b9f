"""Paths to values in the body of a message, such as ``tips[name=thumb].fx``."""

import re
from collections.abc import Callable
from typing import Any, Final

from vegrip.errors import ConfigError

TOKEN: Final = re.compile(r"([^.\[\]]+)|\[(\d{1,4})\]|\[([^\[\]=]+)=([^\[\]]*)\]")
Step = str | int | tuple[str, str]
Steps = tuple[Step, ...]


def parse_path(text: str, where: str) -> tuple[Step, ...]:
    """Return the steps of a path: a key, a number in a list, or the entry of a list with such a value.

    >>> parse_path("tips[name=thumb].force[2]", "map")
    ('tips', ('name', 'thumb'), 'force', 2)
    """
    steps: list[Step] = []
    position = 0
    while position < len(text):
        if text[position] == "." and steps:
            position += 1
        match = TOKEN.match(text, position)
        if match is None:
            raise ConfigError(
                f"{where}: {text!r} is no path; write it like fingers[0].force.z or tips[name=thumb].fx"
            )
        key, index, name, value = match.groups()
        steps.append(key if key is not None else int(index) if index is not None else (name, value))
        position = match.end()
    if not steps:
        raise ConfigError(f"{where}: the path is empty; write it like fingers[0].force.z")
    return tuple(steps)


def getter(steps: tuple[Step, ...]) -> Callable[[Any], Any]:

    def get(body: Any) -> Any:
        for step in steps:
            if isinstance(step, str):
                body = body.get(step) if isinstance(body, dict) else None
            elif isinstance(step, int):
                body = body[step] if isinstance(body, list) and step < len(body) else None
            else:
                key, value = step
                entries = body if isinstance(body, list) else ()
                body = next((e for e in entries if isinstance(e, dict) and str(e.get(key)) == value), None)
            if body is None:
                return None
        return body

    return get


def put(body: Any, steps: tuple[Step, ...], value: Any) -> Any:
    """Return ``body`` with ``value`` at ``steps``; what is missing on the way is made.

    >>> put(None, ("fingers", 1, "force"), 2.5)
    {'fingers': [None, {'force': 2.5}]}
    """
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if isinstance(step, str):
        body = body if isinstance(body, dict) else {}
        body[step] = put(body.get(step), rest, value)
        return body
    body = body if isinstance(body, list) else []
    if isinstance(step, int):
        body += [None] * (step + 1 - len(body))
        body[step] = put(body[step], rest, value)
        return body
    key, name = step
    entry = next((e for e in body if isinstance(e, dict) and e.get(key) == name), None)
    if entry is None:
        entry = {key: name}
        body.append(entry)
    put(entry, rest, value)
    return body
