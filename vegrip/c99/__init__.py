"""A subset of Python translated to C99, statement by statement: the same text runs as Python, numba and C.

What the subset has: functions of numbers, of flat arrays of doubles, of whole numbers of 64 bits and of bytes
(``m[i]``), and of constant tables; what is read from the last two counts in 64 bits and is converted by hand;
``if``, ``while``, ``for`` over ``range`` and constant tuples; tuples that are returned and taken apart;
``math``; records declared as :class:`ctypes.Structure` (``node.waiting``), and functions that are C already.
What it does not have: lists, strings, closures, default arguments, recursion, a name with two
kinds of value. Whatever is not in the subset is refused with file and line (:class:`UntranslatableError`).

The C does what numba does, operation by operation: both round every product and sum once (compile without
fused multiply-add), both take ``x ** 2`` as a product, and ``min``, ``max`` and comparisons with NaN agree.
"""

from vegrip.c99.kinds import BOOL, BYTES, INT, LONG, LONGS, MEMORY, REAL, VOID, record
from vegrip.c99.names import UntranslatableError
from vegrip.c99.program import Program, translate

__all__ = [
    "BOOL", "BYTES", "INT", "LONG", "LONGS", "MEMORY", "REAL", "VOID", "Program", "UntranslatableError",
    "record", "translate",
]  # fmt: skip
