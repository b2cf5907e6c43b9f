"""A text in single precision behind functions that take doubles: how Python runs what firmware would."""

import re
from collections.abc import Mapping, Sequence

from vegrip.c99.kinds import BYTES, LONGS, MEMORY, REAL, Kind

MOST = 64  # numbers of a memory whose length is known only when it is called
Lengths = Mapping[str, Sequence[int | str]]


def behind_doubles(
    text: str,
    entries: Mapping[str, tuple[Kind, ...]],
    lengths: Lengths,
    prefix: str = "vg",
) -> str:
    """Return ``text`` with its entries as functions of doubles.

    Args:
        text: C in single precision, translated with ``prefix``.
        entries: functions called from outside, with the kinds of their arguments.
        lengths: of the memories of each entry, in the order of its arguments: a number, or an expression in C
            of its arguments a0, a1, ..., then no more than :data:`MOST`.
        prefix: of the names in C.

    """
    for name in entries:
        text = re.sub(rf"\b{prefix}_{name}\b", f"{prefix}_{name}_in_floats", text)
    bridges = (
        _bridge(f"{prefix}_{name}", kinds, list(lengths[name]), _result(text, f"{prefix}_{name}"))
        for name, kinds in entries.items()
    )
    return "\n".join([text, *bridges])


def _result(text: str, name: str) -> str:
    found = re.search(rf"\b(\w+) {name}_in_floats\(", text)
    assert found is not None  # noqa: S101 (the text was translated with this entry)
    return REAL.c if found[1] == "float" else found[1]


def _bridge(name: str, kinds: Sequence[Kind], lengths: list[int | str], result: str) -> str:
    takes, gives, before, after = [], [], [], []
    for i, kind in enumerate(kinds):
        takes.append(f"{kind.c}{'' if kind in (MEMORY, LONGS, BYTES) else ' '}a{i}")
        gives.append(f"f{i}" if kind == MEMORY else f"{'(float)' if kind == REAL else ''}a{i}")
        if kind == MEMORY:
            n = lengths.pop(0)
            room = n if isinstance(n, int) else MOST
            before.append(
                f"    float f{i}[{room}]; for (int i = 0; i < {n}; i++) {{ f{i}[i] = (float)a{i}[i]; }}"
            )
            after.append(f"    for (int i = 0; i < {n}; i++) {{ a{i}[i] = (double)f{i}[i]; }}")
    call = f"{name}_in_floats({', '.join(gives)});"
    returns = result != "void"
    body = [*before, f"    {f'const {result} found = ({result})' if returns else ''}{call}", *after]
    body += ["    return found;"] if returns else []
    head = f"{result} {name}({', '.join(takes)})"
    return "\n".join([head, "{", *body, "}", ""])
