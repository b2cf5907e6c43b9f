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


@dataclass(frozen=True)
class RealType:
    """How C writes real numbers: their type, and what ends literals and the names of functions of math.h."""

    c: str
    literal: str = ""
    function: str = ""

    def spelled(self, kind: Kind) -> str:
        """Return the type in C of a value of ``kind``."""
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
