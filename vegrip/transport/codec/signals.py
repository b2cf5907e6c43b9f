"""The signals of ``fingertip.dbc``: where they stand in a frame, and what their raw values mean.

``struct`` unpacks a whole frame in one call; a signal is then one item of the tuple (a cell), or a few bits
of a one-byte cell. The functions of whole messages are made as text (:func:`compiled`): a call for each
signal takes longer than all else that is done with a frame. `benchmarks/codec.py` measures it against
cantools.

A signal is named after the field it carries. An estimate takes up to four signals: ``x``, ``x_std``,
``x_valid``, ``x_age``; a map of counts one signal ``x_<name>`` for each name; ``x_other`` takes the rest.
"""

import math
import struct
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import CodeType
from typing import Any, Final

from cantools.database.can import Message as DbcMessage
from cantools.database.can import Signal

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import UNKNOWN, Estimate
from vegrip.transport.codec.schema import Field

INTEGERS = {8: "b", 16: "h", 32: "i", 64: "q"}
FLOATS = {32: "f", 64: "d"}
NOT_MEASURED: Final = "not measured"
NEVER: Final = "never"
NONE: Final = "none"
OTHER: Final = "other"
FLOAT32_MAX: Final = 3.4028234663852886e38
SNAP: Final = 1e-9  # of a step: a value that is on the grid but for rounding is not rounded down a step
PARTS_OF_ESTIMATE = {"": "value", "_std": "std", "_valid": "valid", "_age": "age"}

Raw = int | float
Cells = tuple[Raw, ...]


def compiled(lines: Sequence[str], scope: Mapping[str, Any]) -> Any:
    """Return the function ``made`` of a text that holds nothing but numbers and names of ours."""
    known = dict(scope)
    exec(_code("\n".join(lines)), known)  # noqa: S102
    return known["made"]


@lru_cache(maxsize=256)
def _code(text: str) -> CodeType:  # of all fingers and hands alike; to compile takes a hundred times as long
    return compile(text, "<frame>", "exec")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a signal stands: a whole cell (``mask`` = 0) or some bits of it."""

    cell: int
    shift: int = 0
    mask: int = 0

    def text(self, offset: int = 0) -> str:
        cell = f"cells[{self.cell + offset}]"
        return f"{cell} >> {self.shift} & {self.mask}" if self.mask else cell

    def get(self, cells: Sequence[Any]) -> Any:
        return cells[self.cell] >> self.shift & self.mask if self.mask else cells[self.cell]

    def put(self, cells: list[Any], raw: Raw) -> None:
        """Set the raw value in the row to be packed; bits must be clear before."""
        cells[self.cell] = cells[self.cell] | int(raw) << self.shift if self.mask else raw


class Converter(ABC):
    """One kind of signal."""

    __slots__ = ()

    @property
    def absent(self) -> Raw:
        return 0

    @abstractmethod
    def read(self, raw: Any) -> Any:
        """Return the value, None when the raw value means nothing."""

    @abstractmethod
    def write(self, value: Any) -> Raw | None:
        """Return the raw value, None when the signal cannot carry ``value``."""

    def clip(self, value: Any) -> Raw | None:  # noqa: B027 (what carries every value need not answer)
        """Return what is sent instead of a ``value`` that cannot be carried, None to send no message."""

    def reading(self, raw: str, rest: str) -> str:
        """Return the text of :meth:`read` for a name; ``rest`` is its own name, for what is not usual."""
        return f"{rest}({raw})"

    def writing(self, value: str, rest: str) -> str:
        """Return the text of :meth:`write` for a name, as of :meth:`reading`."""
        return f"{rest}({value})"


@dataclass(frozen=True, slots=True)
class Real(Converter):
    """A float32; NaN travels as itself."""

    required: bool = False
    infinite: bool = False
    missing: float = math.nan  # the value of "not measured"

    @property
    def absent(self) -> Raw:
        return self.missing

    def read(self, raw: float) -> float | None:
        if raw - raw == 0.0:
            return raw
        if math.isnan(raw):
            return None if self.required else self.missing
        return raw if self.infinite else None

    def write(self, value: float) -> float | None:
        if -FLOAT32_MAX <= value <= FLOAT32_MAX:
            return value
        return value if not math.isfinite(value) and self.read(value) is not None else None

    def clip(self, value: float) -> float | None:
        """Send the largest number for a required value, "not measured" for any other."""
        if not self.required:
            return self.absent
        return math.copysign(FLOAT32_MAX, value) if math.isfinite(value) else None

    def reading(self, raw: str, rest: str) -> str:
        return f"({raw} if {raw} - {raw} == 0.0 else {rest}({raw}))"

    def writing(self, value: str, rest: str) -> str:
        return f"({value} if {-FLOAT32_MAX!r} <= {value} <= {FLOAT32_MAX!r} else {rest}({value}))"


@dataclass(frozen=True, slots=True)
class Scaled(Converter):
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
        return self._special(self.missing) or 0

    def read(self, raw: int) -> float | None:
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

    def reading(self, raw: str, rest: str) -> str:
        return f"({raw} * {self.scale!r} if {self.low} <= {raw} <= {self.high} else {rest}({raw}))"

    def writing(self, value: str, rest: str) -> str:
        if self.rounds_down:
            return f"{rest}({value})"
        rounded = f"(r := round({value} / {self.scale!r}))"
        inside = f"{value} - {value} == 0.0 and {self.low} <= {rounded} <= {self.high}"
        return f"(r if {inside} else {rest}({value}))"

    def _special(self, value: float) -> int | None:
        for raw, meaning in self.special.items():
            if meaning == value or (math.isnan(meaning) and math.isnan(value)):
                return raw
        return None


@dataclass(frozen=True, slots=True)
class Flag(Converter):
    """One bit."""

    def read(self, raw: int) -> bool:
        return raw == 1

    def write(self, value: bool) -> int:
        return 1 if value else 0


@dataclass(frozen=True, slots=True)
class Count(Converter):
    """A number of events; it stops at the largest the signal holds."""

    high: int

    def read(self, raw: int) -> int:
        return raw

    def write(self, value: int) -> int:
        """Saturate, never wrap: a wrapped count would look like a restart."""
        return min(max(value, 0), self.high)


@dataclass(frozen=True, slots=True)
class Coded(Converter):
    """A member of an enumeration or a word of a value table; ``other`` stands for words without a code."""

    meaning: Mapping[int, Any]
    code: Mapping[Any, int]
    other: int | None = None

    def read(self, raw: int) -> Any:
        return self.meaning.get(raw)

    def write(self, value: Any) -> int | None:
        return self.code.get(value)

    def clip(self, value: Any) -> int | None:  # noqa: ARG002
        return self.other


def converter(field: Field, signal: Signal) -> Converter:
    """Choose the converter for ``signal``, which carries ``field`` or a part of it."""
    if field.kind == "text":
        return _words(signal)
    enumeration = field.enumeration
    if enumeration is not None:
        codes = signal.choices or range(int(signal.maximum or 0) + 1)  # a value table, or all sets of flags
        meaning = {int(raw): enumeration(raw) for raw in codes}
        return Coded(meaning, {member: raw for raw, member in meaning.items()})
    if field.kind in ("count", "counts"):
        return Count((1 << signal.length) - 1)
    if field.kind == "flag" or signal.name.endswith("_valid"):
        return Flag()
    return _quantity(field, signal)


def _words(signal: Signal) -> Coded:
    labels = {raw: str(label) for raw, label in (signal.choices or {}).items()}
    meaning = {raw: "" if word == NONE else word for raw, word in labels.items()}
    code = {word: raw for raw, word in meaning.items()}
    return Coded(meaning, code, code.get(OTHER))


def _quantity(field: Field, signal: Signal) -> Converter:
    spread = field.kind == "estimate" and signal.name != field.name  # std and age: unknown is infinite
    missing = math.inf if spread else math.nan
    if signal.is_float:
        return Real(field.required, field.infinite or spread, missing)
    known = {NOT_MEASURED: missing, NEVER: math.inf}
    labels = {raw: str(label) for raw, label in (signal.choices or {}).items()}
    rounding = signal.dbc.attributes.get("Rounding")
    return Scaled(
        scale=float(signal.scale),
        low=round((signal.minimum or 0) / signal.scale),
        high=round((signal.maximum or 0) / signal.scale),
        special={raw: known[label] for raw, label in labels.items() if label in known},
        rounds_down=rounding is not None and rounding.definition.choices[int(rounding.value)] == "down",
        required=field.required,
        missing=missing,
    )


def belongs(field: Field, name: str) -> bool:
    """Whether the signal ``name`` carries ``field`` or a part of it."""
    if field.kind == "counts":
        return name.startswith(f"{field.name}_")
    if field.kind == "estimate":
        return name.startswith(field.name) and name.removeprefix(field.name) in PARTS_OF_ESTIMATE
    return name == field.name


def value_text(field: Field, name: str, names: Iterable[str]) -> str:
    """Return the text of what the signal ``name``, one of ``names``, carries of a message ``m``."""
    suffix = name.removeprefix(field.name)
    if field.kind == "counts" and suffix != f"_{OTHER}":
        return f"m.{field.name}.get({suffix[1:]!r}, 0)"
    if field.kind == "counts":
        own = tuple(
            one.removeprefix(f"{field.name}_") for one in names if belongs(field, one) and one != name
        )
        return f"sum(count for key, count in m.{field.name}.items() if key not in {own!r})"
    if field.kind == "time":
        return f"(m.{field.name} - m.stamp) / {NS}"
    return f"m.{field.name}.{PARTS_OF_ESTIMATE[suffix]}" if field.kind == "estimate" else f"m.{field.name}"


def field_text(field: Field, texts: Mapping[str, str]) -> str:
    """Return the text of a field, made of the ``texts`` of its signals, in the scope of :data:`MAKERS`."""
    if field.kind == "estimate":
        parts = [
            texts.get(field.name + suffix, f"unknown.{part}") for suffix, part in PARTS_OF_ESTIMATE.items()
        ]
        return f"estimate({', '.join(parts)})"
    if field.kind == "counts":
        keys = [name.removeprefix(f"{field.name}_") for name in texts]
        return f"named({keys!r}, ({', '.join(texts.values())},))"
    return f"after({texts[field.name]}, stamp)" if field.kind == "time" else texts[field.name]


def _estimate(*parts: Any) -> Estimate | None:
    if None in parts:
        return None
    value, std, is_valid, age = parts
    known = not math.isnan(value)  # a value that was clipped on the way is not valid any more
    return Estimate(value, std, is_valid and known, age)


def _named(keys: Sequence[str], counts: Sequence[int]) -> dict[str, int]:
    return {key: count for key, count in zip(keys, counts, strict=True) if count}


def _after(seconds: float | None, stamp: int) -> int | None:
    return None if seconds is None else stamp + round(seconds * NS)


MAKERS: Final[Mapping[str, Callable[..., Any] | Estimate]] = {
    "estimate": _estimate,
    "named": _named,
    "after": _after,
    "unknown": UNKNOWN,
}


def plan(message: DbcMessage) -> tuple[struct.Struct, Mapping[str, Place]]:
    """Lay out the cells of ``message``; reserved bytes become padding, sent as zero."""
    groups: dict[int, list[Signal]] = {}  # by their first byte
    for signal in sorted(message.signals, key=lambda s: s.start):
        fits = signal.start % 8 == 0 if signal.length >= 8 else signal.start % 8 + signal.length <= 8
        multiplexed = signal.is_multiplexer or signal.multiplexer_ids
        if not fits or multiplexed or signal.byte_order != "little_endian":
            raise _unsupported(message, signal)
        if signal.offset != 0 or (signal.is_float and signal.scale != 1):
            raise ConfigError(
                f"fingertip.dbc: {message.name}.{signal.name} must have no offset, a float no scale"
            )
        groups.setdefault(signal.start // 8, []).append(signal)
    places: dict[str, Place] = {}
    codes: list[str] = []
    end = 0  # bytes laid out so far
    for cell, (start, signals) in enumerate(groups.items()):
        codes.append("x" * (start - end))
        if signals[0].length >= 8:
            codes.append(_struct_code(message, signals[0]))
            places[signals[0].name] = Place(cell)
            end = start + signals[0].length // 8
        else:
            codes.append("B")
            places |= {s.name: Place(cell, s.start % 8, (1 << s.length) - 1) for s in signals}
            end = start + 1
    return struct.Struct("<" + "".join(codes) + "x" * (message.length - end)), places


def _struct_code(message: DbcMessage, signal: Signal) -> str:
    code = (FLOATS if signal.is_float else INTEGERS).get(signal.length)
    if code is None:
        raise _unsupported(message, signal)
    return code if signal.is_float or signal.is_signed else code.upper()


def _unsupported(message: DbcMessage, signal: Signal) -> ConfigError:
    return ConfigError(
        f"fingertip.dbc: {message.name}.{signal.name} must be little-endian, not multiplexed, and"
        " either inside one byte or of 8, 16, 32 or 64 bits on a byte boundary"
    )
