"""Which field of which topic: ``/finger/wrench:wrench.force.z``, ``/joints:effort[2]``."""

import math
import re
from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np

from vegrip.clock import NS
from vegrip.errors import RecordingError

COLUMN: Final = re.compile(r"(?P<topic>[^:\s]+):(?P<path>\w+(\[\d+\])*(\.\w+(\[\d+\])*)*)")
LONGEST_INDEX: Final = 9  # digits
PATH_STEP: Final = re.compile(r"\w+|\[\d+\]")


@dataclass(frozen=True, slots=True)
class BagField:
    """One number in the messages of one topic."""

    column: str  # as the map has it
    topic: str
    steps: tuple[str | int, ...]

    @classmethod
    def parse(cls, column: str, channel: str) -> Self:
        """Read ``/topic:field.field[index]``; ``channel`` is named in the complaint."""
        match = COLUMN.fullmatch(column)
        if match is None:
            raise RecordingError(
                f"{channel}: {column!r} names no field; write it like /finger/wrench:wrench.force.z"
            )
        steps = [step.strip("[]") for step in PATH_STEP.findall(match["path"])]
        if any(step.isdigit() and (len(step) > LONGEST_INDEX or not step.isascii()) for step in steps):
            raise RecordingError(f"{channel}: {column[:80]!r} has an index that no array has")
        return cls(column, match["topic"], tuple(int(step) if step.isdigit() else step for step in steps))

    def value(self, message: Any) -> float:
        """Return the number in ``message``.

        Raises:
            RecordingError: the type has no such field, or it is not a number.
            IndexError: the array of this message is too short.

        """
        for step in self.steps:
            message = _element(message, step) if isinstance(step, int) else _member(message, step)
        if not isinstance(message, bool | int | float | np.bool_ | np.integer | np.floating):
            raise RecordingError(f"{self.column} is {_kind(message)}, not a number")
        return float(message)


def header_stamp(message: Any) -> int | None:
    """Return the stamp of the header [ns], None when the message has no header."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        return None
    return int(stamp.sec) * NS + int(stamp.nanosec)


def is_infinite(values: list[float]) -> bool:
    """Return whether one of ``values`` is infinite."""
    return any(map(math.isinf, values))


def _member(message: Any, name: str) -> Any:
    names = [key for key in getattr(message, "__dataclass_fields__", {}) if not key.startswith("__")]
    if name not in names:
        there = f"there are {', '.join(names)}" if names else f"it is {_kind(message)}"
        raise RecordingError(f"has no field {name!r}; {there}")
    return getattr(message, name)


def _element(message: Any, index: int) -> Any:
    if not isinstance(message, np.ndarray | list | tuple):
        raise RecordingError(f"has no element [{index}]; it is {_kind(message)}")
    return message[index]


def _kind(value: Any) -> str:
    if isinstance(value, np.ndarray | list | tuple):
        return f"an array of {len(value)}: say which with [index]"
    if isinstance(value, str):
        return f"the text {value[:40]!r}"
    names = getattr(value, "__dataclass_fields__", {})
    return f"a message with {', '.join(key for key in names if not key.startswith('__'))}"
