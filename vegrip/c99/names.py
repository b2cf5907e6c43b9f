"""Names that C has taken, and how long lines are broken."""

import ast
import textwrap
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
    return f"{function}, statement {number + 1}"


RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile
    while _Bool bool true false NAN INFINITY isnan isinf isfinite int32_t int64_t uint32_t
    asm near far interrupt main class new delete this template typename private public protected
    """.split()  # noqa: SIM905 (a table to read)
)
LINE_WIDTH = 110
INDENT = "    "


def local(name: str) -> str:
    return f"{name}_c" if name in RESERVED else name


def joined(prefix: str, name: str) -> str:
    return f"{prefix}_{name.strip('_')}"


def comment(text: str) -> list[str]:
    lines = [line.rstrip() for line in text.strip().replace("*/", "* /").splitlines()]
    first = [f"/* {lines[0]}", *(f" * {line}".rstrip() for line in lines[1:])]
    if len(first) == 1 and len(first[0]) + 3 <= LINE_WIDTH:
        return [f"{first[0]} */"]
    return [*first[:-1], f"{first[-1]} */"]


def broken(line: str) -> list[str]:
    """Break a line of code that is too long, at spaces."""
    if len(line) <= LINE_WIDTH or line.lstrip().startswith(("#", "/*", "*")):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.wrap(
        line.strip(),
        LINE_WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + 2 * INDENT,
        break_long_words=False,
        break_on_hyphens=False,
    )
