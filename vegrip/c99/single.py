"""C text in single precision: ``float`` in place of ``double``, with its literals and functions.

A float keeps seven digits whatever its size, so numbers of any unit fit as they are; only what lies beyond
its range is brought into it. Where a text needs eight digits or more, single precision is not for it.
"""

import re

SMALLEST_FLOAT = 1e-30
"""What a constant nearer to 0 becomes: its reciprocal is a float as well."""
HUGE = 1e30
"""What a larger constant becomes."""
FUNCTIONS = frozenset(
    ("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "cos", "cosh", "erf", "erfc",
     "exp", "exp2", "expm1", "fabs", "floor", "fmax", "fmin", "fmod", "hypot", "log", "log10", "log1p",
     "log2", "pow", "round", "sin", "sinh", "sqrt", "tan", "tanh", "trunc")
)  # fmt: skip
TOKEN = re.compile(
    r"/\*.*?\*/|//[^\n]*|\"[^\"\n]*\"|(?P<name>[A-Za-z_]\w*)(?P<call>\()?"
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\w*)",
    re.DOTALL,
)


def single_precision(text: str) -> str:
    """Return ``text`` with every double made a float; comments and strings stay."""
    return TOKEN.sub(_token, text)


def single_literal(value: float) -> float:
    """Return a finite number brought into the range in which a float and its reciprocal exist."""
    size = abs(value)
    if size == 0.0 or SMALLEST_FLOAT <= size <= HUGE:
        return value
    return (SMALLEST_FLOAT if size < SMALLEST_FLOAT else HUGE) * (1.0 if value > 0.0 else -1.0)


def _token(found: re.Match[str]) -> str:
    name, number = found["name"], found["number"]
    if name is not None:
        call = found["call"] or ""
        if name == "double":
            return f"float{call}"
        return f"{name}f{call}" if call and name in FUNCTIONS else found[0]
    if number is not None and _is_real(number):
        value = single_literal(float(number))
        return f"{number if value == float(number) else repr(value)}F"
    return found[0]


def _is_real(number: str) -> bool:
    """Return whether a literal is a double; hexadecimal ones and those with a suffix are not."""
    return bool(re.fullmatch(r"(\d+\.\d*|\.\d+|\d+(?=[eE]))([eE][+-]?\d+)?", number))
