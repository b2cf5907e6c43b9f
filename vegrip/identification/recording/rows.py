"""Messages as rows of a table: one line per message, numbers as numbers, an estimate as four columns."""

import dataclasses
import math
from collections.abc import Callable, Mapping
from enum import Enum, IntFlag
from typing import Any, Final

from vegrip.clock import NS
from vegrip.identification.recording.channels import CHANNELS
from vegrip.messages import (
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    LearnedParameter,
    Message,
    ModelHealth,
    NodeStatus,
    SlipMargin,
)

FILES: Final[dict[type[Message], str]] = {
    FingertipState: "recording.csv",
    ContactEstimate: "contact.csv",
    SlipMargin: "slip_margin.csv",
    ForceCommand: "force_command.csv",
    ModelHealth: "model_health.csv",
    LearnedParameter: "learned.csv",
    NodeStatus: "diagnostics.csv",
}
"""Which file of a finger's folder a message goes to; diagnostics lie beside the fingers."""

STATE_HEADER: Final = ",".join(("t", "episode", *CHANNELS))


def header(kind: type[Message]) -> str:
    """Return the first line of the file of ``kind``."""
    if kind is FingertipState:
        return STATE_HEADER
    names = ["t"]
    for name, is_estimate in _FIELDS[kind]:
        names += [name, f"{name}_std", f"{name}_valid", f"{name}_age"] if is_estimate else [name]
    return ",".join(names)


def row(message: Message, start: int) -> str:
    """Return ``message`` as a line without its end; ``start`` [ns] is the stamp of t = 0."""
    seconds, rest = divmod(message.stamp - start, NS)
    t = f"{seconds}.{rest:09d}" if seconds >= 0 else repr((message.stamp - start) / NS)
    if isinstance(message, FingertipState):
        return ",".join((t, "0", *(_exact(getattr(message, name)) for name in CHANNELS)))
    cells = [t]
    for name, is_estimate in _FIELDS[type(message)]:
        value = getattr(message, name)
        cells += _estimate(value) if is_estimate else [_cell(value)]
    return ",".join(cells)


def _written(kind: type[Message]) -> tuple[tuple[str, bool], ...]:
    """Return the fields that are written, and whether each is an estimate."""
    known = [field for field in dataclasses.fields(kind) if field.name not in ("stamp", "finger")]
    return tuple((field.name, isinstance(field.default, Estimate)) for field in known)


_FIELDS: Final = {kind: _written(kind) for kind in FILES}


def _estimate(estimate: Estimate) -> list[str]:
    return [_float(estimate.value), _float(estimate.std), str(int(estimate.valid)), _float(estimate.age)]


def _cell(value: Any) -> str:
    for kind, text in _CELLS.items():
        if isinstance(value, kind):
            return text(value)
    raise TypeError(f"no way to write {value!r}")


def _float(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.8g}"


def _exact(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def _mapping(value: Mapping[str, int]) -> str:
    return ";".join(f"{_text(key)}={count}" for key, count in value.items())


def _text(value: str) -> str:
    return "".join(" " if c in ',;="\r\n' else c for c in value)


_CELLS: Final[dict[type, Callable[[Any], str]]] = {  # in order: a bool is an int, an enum may be one
    bool: lambda value: str(int(value)),
    IntFlag: lambda value: str(int(value)),
    Enum: lambda value: value.name.lower(),
    int: str,
    float: _float,
    str: _text,
    Mapping: _mapping,
}
