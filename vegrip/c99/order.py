"""Where C leaves open what Python fixes: which operand of an expression is evaluated first.

It matters only where one operand writes to the memory and another reads it.
"""

import ast
from collections.abc import Callable

from vegrip.c99.walk import nodes_of

Writes = Callable[[ast.Call], bool]
"""Whether a call may write to the memory."""


def matters(node: ast.expr, writes: Writes) -> bool:
    """Return whether the result of ``node`` depends on the order of its operands."""
    inner = nodes_of(node)
    if not any(isinstance(one, ast.Call) and writes(one) for one in inner):
        return False
    return any(_mixes(one, writes) for one in inner)


def _mixes(node: ast.AST, writes: Writes) -> bool:
    if isinstance(node, (ast.BoolOp, ast.IfExp)):  # in this order in C, too
        return False
    parts = [part for part in ast.iter_child_nodes(node) if isinstance(part, ast.expr)]
    touching = [part for part in parts if _touches(part)]
    return len(touching) > 1 and any(_writes(part, writes) for part in touching)


def _touches(node: ast.expr) -> bool:
    return any(isinstance(inner, (ast.Subscript, ast.Call)) or is_field(inner) for inner in nodes_of(node))


def is_field(node: ast.AST) -> bool:
    """Return whether ``node`` is a field of a record."""
    return isinstance(node, ast.Attribute) and not (
        isinstance(node.value, ast.Name) and node.value.id == "math"
    )


def _writes(node: ast.expr, writes: Writes) -> bool:
    return any(isinstance(inner, ast.Call) and writes(inner) for inner in nodes_of(node))
