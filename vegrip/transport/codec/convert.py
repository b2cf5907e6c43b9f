"""Raw value <-> physical value, one converter per kind of signal.

Every converter answers three questions. ``read``: what does this raw value mean (None: nothing, refuse the
frame)? ``write``: which raw value carries this (None: none does)? ``clip``: then what is sent instead (None:
do not send the message)? ``absent`` is the raw value of "not measured".

``reading`` and ``writing`` are the usual case of ``read`` and ``write`` as program text, for the functions of
whole frames (:func:`compiled`): a call for each signal takes longer than all else that is done with a frame.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

from cantools.database.can import Signal

from vegrip.transport.codec.cells import Raw

NOT_MEASURED: Final = "not measured"
NEVER: Final = "never"
NONE: Final = "none"
OTHER: Final = "other"
FLOAT32_MAX: Final = 3.4028234663852886e38
SNAP: Final = 1e-9  # of a step: a value that is on the grid but for rounding is not rounded down a step


class Converter(Protocol):
    """One kind of signal."""

    @property
    def absent(self) -> Raw:
        """The raw value of a quantity that was not measured."""

    def read(self, raw: Any) -> Any:
        """Return the value, None when the raw value means nothing."""

    def write(self, value: Any) -> Raw | None:
        """Return the raw value, None when the signal cannot carry ``value``."""

    def clip(self, value: Any) -> Raw | None:
        """Return what is sent instead of a ``value`` that cannot be carried, None to send nothing."""

    def reading(self, raw: str, read: str) -> str:
        """Return the text of :meth:`read` for a name; ``read`` is its own name, for the rest."""

    def writing(self, value: str, write: str) -> str:
        """Return the text of :meth:`write` for a name; ``write`` is its own name, for the rest."""


class Called:
    """What has no usual case."""

    def reading(self, raw: str, read: str) -> str:
        """Call it."""
        return f"{read}({raw})"

    writing = reading


def compiled(lines: Sequence[str], scope: Mapping[str, Any]) -> Any:
    """Return the function ``made`` of a text that holds nothing but numbers and names of ours."""
    known = dict(scope)
    exec("\n".join(lines), known)  # noqa: S102
    return known["made"]


@dataclass(frozen=True, slots=True)
class Real:
    """A float32; NaN travels as itself."""

    required: bool = False
    infinite: bool = False
    missing: float = math.nan  # the value of "not measured"

    @property
    def absent(self) -> Raw:
        """NaN, or infinity for a spread."""
        return self.missing

    def read(self, raw: float) -> float | None:
        """Refuse infinity unless it is allowed, and NaN where the value is required."""
        if raw - raw == 0.0:
            return raw
        if math.isnan(raw):
            return None if self.required else self.missing
        return raw if self.infinite else None

    def write(self, value: float) -> float | None:
        """Refuse what float32 cannot hold."""
        if -FLOAT32_MAX <= value <= FLOAT32_MAX:
            return value
        return value if not math.isfinite(value) and self.read(value) is not None else None

    def clip(self, value: float) -> float | None:
        """Send the largest number for a required value, "not measured" for any other."""
        if not self.required:
            return self.absent
        return math.copysign(FLOAT32_MAX, value) if math.isfinite(value) else None

    def reading(self, raw: str, read: str) -> str:
        """Take a finite number."""
        return f"({raw} if {raw} - {raw} == 0.0 else {read}({raw}))"

    def writing(self, value: str, write: str) -> str:
        """Take what float32 can hold."""
        return f"({value} if {-FLOAT32_MAX!r} <= {value} <= {FLOAT32_MAX!r} else {write}({value}))"


@dataclass(frozen=True, slots=True)
class Scaled:
    """An integer times a scale, with raw values set aside for "not measured" and "never"."""

    scale: float
    low: int
    high: int
    special: Mapping[int, float]
    rounds_down: bool = False
    required: bool = False
    missing: float = math.nan

    @property
    def absent(self) -> Raw:
        """The raw value set aside, zero when there is none."""
        return self._special(self.missing) or 0

    def read(self, raw: int) -> float | None:
        """Scale a raw value inside its range; outside, only the set-aside ones have a meaning."""
        return raw * self.scale if self.low <= raw <= self.high else self.special.get(raw)

    def write(self, value: float) -> int | None:
        """Round to the nearest step, or down for bounds that must not promise too much."""
        if value - value != 0.0:
            return self._special(value)
        steps = value / self.scale
        raw = math.floor(steps + SNAP) if self.rounds_down else round(steps)
        return raw if self.low <= raw <= self.high else None

    def clip(self, value: float) -> int | None:
        """Stop at the end of the range for a required value or a bound from below, else "not measured"."""
        if value > 0 and self.rounds_down and value != math.inf:
            return self.high
        if self.required:
            return (self.high if value > 0 else self.low) if math.isfinite(value) else None
        return self._special(self.missing)

    def reading(self, raw: str, read: str) -> str:
        """Scale what is inside the range."""
        return f"({raw} * {self.scale!r} if {self.low} <= {raw} <= {self.high} else {read}({raw}))"

    def writing(self, value: str, write: str) -> str:
        """Round what the range holds."""
        if self.rounds_down:
            return f"{write}({value})"
        rounded = f"(r := round({value} / {self.scale!r}))"
        inside = f"{value} - {value} == 0.0 and {self.low} <= {rounded} <= {self.high}"
        return f"(r if {inside} else {write}({value}))"

    def _special(self, value: float) -> int | None:
        for raw, meaning in self.special.items():
            if meaning == value or (math.isnan(meaning) and math.isnan(value)):
                return raw
        return None


@dataclass(frozen=True, slots=True)
class Flag(Called):
    """One bit."""

    absent: Raw = 0

    def read(self, raw: int) -> bool:
        """1 is true."""
        return raw == 1

    def write(self, value: bool) -> int:
        """True is 1."""
        return 1 if value else 0

    clip = write


@dataclass(frozen=True, slots=True)
class Count(Called):
    """A number of events; it stops at the largest the signal holds."""

    high: int
    absent: Raw = 0

    def read(self, raw: int) -> int:
        """Return it as it is."""
        return raw

    def write(self, value: int) -> int:
        """Saturate, never wrap: a wrapped count would look like a restart."""
        return min(max(value, 0), self.high)

    clip = write


@dataclass(frozen=True, slots=True)
class Coded(Called):
    """A member of an enumeration or a word of a value table; ``other`` stands for words without a code."""

    meaning: Mapping[int, Any]
    code: Mapping[Any, int]
    other: int | None = None
    absent: Raw = 0

    def read(self, raw: int) -> Any:
        """Look the code up; an unknown one means nothing."""
        return self.meaning.get(raw)

    def write(self, value: Any) -> int | None:
        """Look the value up."""
        return self.code.get(value)

    def clip(self, value: Any) -> int | None:  # noqa: ARG002
        """Send "other" when the table has it."""
        return self.other


def special_values(signal: Signal, missing: float) -> dict[int, float]:
    """Return the raw values that the value table of ``signal`` sets aside."""
    meaning = {NOT_MEASURED: missing, NEVER: math.inf}
    choices: Mapping[int, Any] = signal.choices or {}
    return {raw: meaning[str(label)] for raw, label in choices.items() if str(label) in meaning}


def words(signal: Signal) -> Coded:
    """Return the value table of ``signal`` as texts; "none" is the empty text."""
    meaning = {raw: str(label) for raw, label in (signal.choices or {}).items()}
    meaning = {raw: "" if word == NONE else word for raw, word in meaning.items()}
    code = {word: raw for raw, word in meaning.items()}
    return Coded(meaning, code, code.get(OTHER))
