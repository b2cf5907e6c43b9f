"""The kinds of value that the subset knows, and their names in C."""

import ctypes
from dataclasses import dataclass
from functools import cache
from typing import Any


@dataclass(frozen=True)
class Kind:
    """A kind of value; ``c`` is its type in C."""

    c: str


@dataclass(frozen=True)
class Struct(Kind):
    """A tuple."""

    fields: tuple[Kind, ...]


@dataclass(frozen=True)
class Table(Kind):
    """A constant array of the module; ``c`` is its name. It is not passed on, its functions are repeated."""

    shape: tuple[int, ...]
    item: Kind


@dataclass(frozen=True, eq=False)
class Record(Kind):
    """A pointer to a struct that is declared as a :class:`ctypes.Structure`; ``c`` is ``name *``."""

    name: str
    fields: dict[str, tuple[Kind, int]]  # kind of each, and how many of them; 1: it is no array


@dataclass(frozen=True, eq=False)
class Row(Kind):
    """An array of structs within a struct."""

    item: Record


REAL = Kind("double")
INT = Kind("int32_t")
LONG = Kind("int64_t")
BOOL = Kind("bool")
MEMORY = Kind("double *")
LONGS = Kind("int64_t *")
BYTES = Kind("uint8_t *")
ITEM_KIND = {MEMORY: REAL, LONGS: LONG, BYTES: LONG}
"""Arrays that are passed on and written to -> what an element is read as."""
VOID = Kind("void")
NUMBERS = (REAL, INT, LONG, BOOL)
WHOLES = (INT, LONG)


SCALARS: dict[Any, Kind] = {ctypes.c_double: REAL, ctypes.c_int64: LONG, ctypes.c_bool: BOOL}
ARRAYS: dict[Any, Kind] = {ctypes.c_double: MEMORY, ctypes.c_int64: LONGS, ctypes.c_uint8: BYTES}


@cache
def record(declared: type[ctypes.Structure], prefix: str = "vg") -> Record:
    """Return the kind of a pointer to ``declared``, of numbers, arrays of numbers, and other such structs."""
    fields: dict[str, tuple[Kind, int]] = {}
    declarations: Any = declared._fields_
    for name, kind in declarations:
        item, count = (kind._type_, kind._length_) if issubclass(kind, ctypes.Array) else (kind, 1)
        if issubclass(item, ctypes.Structure):
            inner = record(item, prefix)
            fields[name] = (inner if kind is item else Row(inner.c, inner), count)
        else:
            fields[name] = ((SCALARS if kind is item else ARRAYS)[item], count)
    name = f"{prefix}_{declared.__name__.lower()}"
    return Record(f"{name} *", name, fields)


@dataclass(frozen=True)
class RealType:
    """How C writes real numbers: their type, and what ends literals and the names of functions of math.h."""

    c: str
    literal: str = ""
    function: str = ""

    def spelled(self, kind: Kind) -> str:
        return {REAL: self.c, MEMORY: f"{self.c} *"}.get(kind, kind.c)


DOUBLE = RealType("double")
FLOAT = RealType("float", "F", "f")


def common(a: Kind, b: Kind) -> Kind | None:
    """Return the kind that holds values of both, or None."""
    if a == b:
        return a
    if {a, b} <= {REAL, INT}:
        return REAL
    if {a, b} == {INT, LONG}:
        return LONG
    return None
