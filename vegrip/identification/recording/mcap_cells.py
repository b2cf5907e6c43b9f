"""Cells of our tables <-> JSON objects, without a number being read on the way.

A number goes over as the text it is written with, so that it comes back with every digit. Two rules make up
for what JSON lacks: an empty cell (not measured) is left out, and infinity is ``1e999``, which is a number by
JSON's grammar and which Python and JavaScript read as infinity.
"""

import json
import re
from collections.abc import Mapping, Sequence
from enum import IntFlag
from typing import Any, Final

from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import CHANNELS
from vegrip.messages import FingertipState, Message
from vegrip.transport.codec.schema import Field, message_set

NUMBER: Final = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][+-]?\d+)?")
INFINITY: Final = {"inf": "1e999", "-inf": "-1e999"}
FINITE: Final = {token: cell for cell, token in INFINITY.items()}
WORDS: Final = re.compile(r'[^,"\r\n]*')
"""What a cell of text may hold, as the recorder writes it."""


def properties(kind: type[Message]) -> dict[str, dict[str, str]]:
    """Return column -> JSON schema of every column of the table of ``kind``, with its unit as description."""
    found = {"t": _number("s")}
    if kind is FingertipState:
        found["episode"] = _number("1")
        return found | {name: _number(quantity.unit) for name, quantity in CHANNELS.items()}
    for field in message_set().messages[kind].fields:
        found |= _property(field)
    return found


def json_schema(kind: type[Message], columns: Sequence[str]) -> bytes:
    """Return the JSON schema of the messages that carry ``columns``; nothing but the time is required."""
    known = properties(kind)
    chosen = {name: known[name] for name in columns}
    schema = {"title": f"vegrip.{kind.__name__}", "type": "object", "properties": chosen, "required": ["t"]}
    return json.dumps(schema).encode()


def to_json(cells: Mapping[str, str], known: Mapping[str, Mapping[str, str]]) -> bytes:
    """Return one row as a JSON object; ``known`` says which columns are numbers.

    Raises:
        RecordingError: a cell that is neither empty nor of its column's type.

    """
    members = [f'"{name}":{_token(name, cell, known[name])}' for name, cell in cells.items() if cell]
    return f"{{{','.join(members)}}}".encode()


def from_json(data: bytes, columns: Sequence[str]) -> str:
    """Return a JSON object as a line of the table with these ``columns``.

    Raises:
        RecordingError: not a JSON object, a member that is no column, or a value that no cell holds.

    """
    try:
        body = json.loads(data, parse_float=str, parse_int=str)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"is not JSON ({error})") from None
    if not isinstance(body, dict):
        raise RecordingError("is not a JSON object")
    unknown = sorted(body.keys() - set(columns))
    if unknown:
        raise RecordingError(f"has the unknown field {unknown[0]!r}")
    return ",".join(_cell(name, body.get(name, "")) for name in columns)


def _property(field: Field) -> dict[str, dict[str, str]]:
    if field.name in ("stamp", "finger"):  # the stamp is the time of the message, the finger its topic
        return {}
    if field.kind == "estimate":
        spread = {f"{field.name}_std": field.unit, f"{field.name}_valid": "1", f"{field.name}_age": "s"}
        return {name: _number(unit) for name, unit in ({field.name: field.unit} | spread).items()}
    named = field.enumeration is not None and not issubclass(field.enumeration, IntFlag)
    if named or field.kind in ("name", "text", "counts"):
        return {field.name: {"type": "string"}}
    return {field.name: _number(field.unit or "1")}


def _number(unit: str) -> dict[str, str]:
    return {"type": "number", "description": f"[{unit}]"}


def _token(name: str, cell: str, schema: Mapping[str, str]) -> str:
    if schema["type"] == "string":
        return json.dumps(cell)
    if cell in INFINITY or NUMBER.fullmatch(cell):
        return INFINITY.get(cell, cell)
    raise RecordingError(f"{name} is {cell!r}, which is not a number")


def _cell(name: str, value: Any) -> str:
    if not isinstance(value, str) or not WORDS.fullmatch(value):
        raise RecordingError(f"{name} is {value!r}, which is neither a number nor plain text")
    return FINITE.get(value, value)
