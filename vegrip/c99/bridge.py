"""A text in single precision behind functions that take doubles: how Python runs what firmware would."""

import re
from collections.abc import Mapping, Sequence

from vegrip.c99.kinds import MEMORY, REAL, Kind
from vegrip.c99.single import single_precision


def behind_doubles(
    text: str,
    entries: Mapping[str, tuple[Kind, ...]],
    lengths: Mapping[str, Sequence[int]],
    prefix: str = "vg",
) -> str:
    """Return ``text`` in single precision, with its entries as functions of doubles.

    Args:
        text: C, translated with ``prefix``.
        entries: functions called from outside, with the kinds of their arguments: numbers and memories.
        lengths: of the memories of each entry, in the order of its arguments.
        prefix: of the names in C.

    """
    single = single_precision(text)
    for name in entries:
        single = re.sub(rf"\b{prefix}_{name}\b", f"{prefix}_{name}_in_floats", single)
    returns = {name: bool(re.search(rf"\bfloat {prefix}_{name}_in_floats\(", single)) for name in entries}
    bridges = (
        _bridge(f"{prefix}_{name}", kinds, list(lengths[name]), returns=returns[name])
        for name, kinds in entries.items()
    )
    return "\n".join([single, *bridges])


def _bridge(name: str, kinds: Sequence[Kind], lengths: list[int], *, returns: bool) -> str:
    """Return one function that copies its memories in and out."""
    takes, gives, before, after = [], [], [], []
    for i, kind in enumerate(kinds):
        takes.append(f"{kind.c}{'' if kind == MEMORY else ' '}a{i}")
        gives.append(f"f{i}" if kind == MEMORY else f"({REAL.c.replace('double', 'float')})a{i}")
        if kind == MEMORY:
            n = lengths.pop(0)
            before.append(
                f"    float f{i}[{n}]; for (int i = 0; i < {n}; i++) {{ f{i}[i] = (float)a{i}[i]; }}"
            )
            after.append(f"    for (int i = 0; i < {n}; i++) {{ a{i}[i] = (double)f{i}[i]; }}")
    call = f"{name}_in_floats({', '.join(gives)});"
    body = [*before, f"    {'const double found = (double)' if returns else ''}{call}", *after]
    body += ["    return found;"] if returns else []
    head = f"{'double' if returns else 'void'} {name}({', '.join(takes)})"
    return "\n".join([head, "{", *body, "}", ""])
