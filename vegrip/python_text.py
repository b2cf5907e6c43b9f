"""Texts of Python as trees, for effects in files and for what becomes C."""

import ast
import threading
from typing import Final

_PARSING: Final = threading.Lock()


def parsed(text: str) -> ast.Module:
    """Parse ``text``, one thread at a time.

    CPython counts the depth of the tree it builds in one place for all threads; two at once can end in
    "SystemError: AST constructor recursion depth mismatch" (seen with 3.11.7).
    """
    with _PARSING:
        return ast.parse(text)
