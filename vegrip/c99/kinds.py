"""The kinds of value that the subset knows, and their names in C."""

from dataclasses import dataclass


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


REAL = Kind("double")
INT = Kind("int32_t")
BOOL = Kind("bool")
MEMORY = Kind("double *")
VOID = Kind("void")
NUMBERS = (REAL, INT, BOOL)


def common(a: Kind, b: Kind) -> Kind | None:
    """Return the kind that holds values of both, or None."""
    if a == b:
        return a
    if {a, b} <= {REAL, INT}:
        return REAL
    return None
