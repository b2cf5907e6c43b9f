"""The signals of a field: which of them make it up, how to get it out of a message and back.

A signal is named after the field it carries. An estimate takes up to four signals: ``x``, ``x_std``,
``x_valid``, ``x_age``; a map of counts one signal ``x_<name>`` for each name; ``x_other`` takes the rest.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import Any

from cantools.database.can import Signal

from vegrip.clock import NS
from vegrip.messages import UNKNOWN, Estimate
from vegrip.transport.codec.cells import Place, Raw
from vegrip.transport.codec.convert import (
    OTHER,
    Coded,
    Converter,
    Count,
    Flag,
    Real,
    Scaled,
    compiled,
    special_values,
    words,
)
from vegrip.transport.codec.schema import Enumeration, Field

Cells = tuple[Raw, ...]
Read = Callable[[Cells], Any]
ReadRow = Callable[[Cells], Sequence[Any] | None]
Get = Callable[[Any], Any]

PARTS_OF_ESTIMATE = {"": "value", "_std": "std", "_valid": "valid", "_age": "age"}


def converter(field: Field, signal: Signal) -> Converter:
    """Choose the converter for ``signal``, which carries ``field`` or a part of it."""
    if field.kind == "text":
        return words(signal)
    enumeration = field.enumeration
    if enumeration is not None:
        return _enumerated(enumeration, signal)
    if field.kind in ("count", "counts"):
        return Count((1 << signal.length) - 1)
    if field.kind == "flag" or signal.name.endswith("_valid"):
        return Flag()
    return _quantity(field, signal)


def belongs(field: Field, name: str) -> bool:
    """Whether the signal ``name`` carries ``field`` or a part of it."""
    if field.kind == "counts":
        return name.startswith(f"{field.name}_")
    if field.kind == "estimate":
        return name.startswith(field.name) and name.removeprefix(field.name) in PARTS_OF_ESTIMATE
    return name == field.name


def getter(field: Field, name: str, names: tuple[str, ...]) -> Get:
    """Return the function that takes the value of the signal ``name``, one of ``names``, from a message."""
    if field.kind == "counts":
        return _count_of(field, name, names)
    get: Get = compiled([f"def made(m): return {attribute(field, name)}"], {})
    return get


def attribute(field: Field, name: str) -> str:
    """Return the text of what the signal ``name`` carries of a message ``m``, "" where there is none."""
    if field.kind == "counts":
        return ""
    if field.kind == "time":
        return f"(m.{field.name} - m.stamp) / {NS}"
    suffix = name.removeprefix(field.name)
    part = f".{PARTS_OF_ESTIMATE[suffix]}" if field.kind == "estimate" else ""
    return f"m.{field.name}{part}"


def reader(field: Field, places: Mapping[str, tuple[Place, Converter]]) -> Read:
    """Return the function that makes the field from the cells of a frame, None when they mean nothing."""
    if field.kind == "estimate":
        return _estimate(field, places)
    if field.kind == "counts":
        return _counts(field, places)
    value = _single(*places[field.name])
    return _nanoseconds(value) if field.kind == "time" else value


def row_reader(fields: Sequence[tuple[Read, Place | None, Converter | None]]) -> ReadRow:
    """Return the function that makes all fields of a message, None when one of them means nothing.

    Each field has a reader; one whole cell that is converted has its place and converter, too.
    """
    scope, values, cells = {}, [], []
    for i, (read, place, convert) in enumerate(fields):
        if place is None or place.mask or convert is None:
            scope[f"f{i}"] = read
            values.append(f"f{i}(cells)")
        else:
            scope[f"f{i}"] = convert.read
            cells.append(f" c{i} = cells[{place.cell}]")
            values.append(convert.reading(f"c{i}", f"f{i}"))
    lines = ["def made(cells):", *cells, f" values = ({', '.join(values)},)"]
    row: ReadRow = compiled([*lines, " return None if None in values else values"], scope)
    return row


def _enumerated(cls: Enumeration, signal: Signal) -> Coded:
    codes = signal.choices or range(int(signal.maximum or 0) + 1)  # a value table, or all sets of flags
    meaning = {int(raw): cls(raw) for raw in codes}
    return Coded(meaning, {member: raw for raw, member in meaning.items()})


def _quantity(field: Field, signal: Signal) -> Converter:
    spread = field.kind == "estimate" and signal.name != field.name  # std and age: unknown is infinite
    missing = math.inf if spread else math.nan
    if signal.is_float:
        return Real(field.required, field.infinite or spread, missing)
    return Scaled(
        scale=float(signal.scale),
        low=round((signal.minimum or 0) / signal.scale),
        high=round((signal.maximum or 0) / signal.scale),
        special=special_values(signal, missing),
        rounds_down=_rounds_down(signal),
        required=field.required,
        missing=missing,
    )


def _rounds_down(signal: Signal) -> bool:
    rounding = signal.dbc.attributes.get("Rounding")
    return rounding is not None and rounding.definition.choices[int(rounding.value)] == "down"


def _single(place: Place, convert: Converter) -> Read:
    cell, get, read = place.cell, place.get, convert.read
    return (lambda cells: read(get(cells))) if place.mask else (lambda cells: read(cells[cell]))


def _nanoseconds(value: Read) -> Read:
    def duration(cells: Cells) -> int | None:
        seconds = value(cells)
        return None if seconds is None else round(seconds * NS)

    return duration


def _estimate(field: Field, places: Mapping[str, tuple[Place, Converter]]) -> Read:
    def part(suffix: str, default: Any) -> Read:
        found = places.get(field.name + suffix)
        return _single(*found) if found else lambda _: default

    value, std = part("", UNKNOWN.value), part("_std", UNKNOWN.std)
    valid, age = part("_valid", UNKNOWN.valid), part("_age", UNKNOWN.age)

    def estimate(cells: Cells) -> Estimate | None:
        parts = (value(cells), std(cells), valid(cells), age(cells))
        if None in parts:
            return None
        known = not math.isnan(parts[0])  # a value that was clipped on the way is not valid any more
        return Estimate(parts[0], parts[1], parts[2] and known, parts[3])

    return estimate


def _counts(field: Field, places: Mapping[str, tuple[Place, Converter]]) -> Read:
    counts = [(name.removeprefix(f"{field.name}_"), _single(*place)) for name, place in places.items()]

    def named(cells: Cells) -> dict[str, int]:
        values = ((name, count(cells)) for name, count in counts)
        return {name: count for name, count in values if count}

    return named


def _count_of(field: Field, name: str, names: tuple[str, ...]) -> Get:
    of = attrgetter(field.name)
    key = name.removeprefix(f"{field.name}_")
    if key != OTHER:
        return lambda message: of(message).get(key, 0)
    own = {n.removeprefix(f"{field.name}_") for n in names if belongs(field, n)} - {OTHER}
    return lambda message: sum(count for key, count in of(message).items() if key not in own)
