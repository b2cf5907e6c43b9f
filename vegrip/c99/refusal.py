"""What is said of a line that has no counterpart in C."""

import ast
from collections.abc import Callable

from vegrip.errors import ModelError

Place = Callable[[str, int], str]
"""Where a statement stands for its author: name of the function and the statement's number -> file:line."""


class UntranslatableError(ModelError):
    """A line outside the subset; names file and line."""


class RefusedError(Exception):
    """The same, before it is known where the line stands."""


def refused(node: ast.AST, reason: str) -> RefusedError:
    return RefusedError(f"`{ast.unparse(node).splitlines()[0]}`: {reason}")


def statements(tree: ast.FunctionDef) -> list[ast.stmt]:
    """Return the statements of a function in the order of the text, docstring and ``pass`` left out.

    The order survives the way from an author's file into a generated module, line numbers do not.
    """
    found: list[ast.stmt] = []

    def walk(body: list[ast.stmt]) -> None:
        for node in body:
            if is_text(node) or isinstance(node, ast.Pass):
                continue
            found.append(node)
            for inner in ("body", "orelse", "finalbody"):
                walk(getattr(node, inner, []))

    walk(tree.body)
    return found


def is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def unknown_place(function: str, number: int) -> str:
    """Say where a statement stands when only the generated text is known."""
    return f"{function}, statement {number + 1}"
