"""The text of hooks, made fit to stand together in one generated file.

Docstrings and annotations go, so that neither changes the compiled module; every function gets a name of its
own; constants and helper functions that a hook uses from its file come along. Whatever else it uses is
refused: the same text must run as plain Python, compiled, and one day as C.
"""

import ast
import builtins
import inspect
import textwrap
import types
from collections.abc import Callable
from typing import Any

from vegrip.effects.contract import Hook
from vegrip.errors import ModelError
from vegrip.python_text import parsed

ALLOWED = {"abs", "bool", "float", "int", "max", "min", "range", "round"}


class Texts:
    """Collects function texts and constants under unique names, each once."""

    def __init__(self) -> None:
        self.parts: dict[str, str] = {}

    def add_hook(self, effect: str, index: int, hook: Hook) -> str:
        """Add a hook and what it needs; return its name in the generated file."""
        name = f"{effect}__{hook.stage}{index}"
        self._add(effect, name, hook.source or _text(effect, hook.function), hook.function.__globals__)
        return name

    def _add(self, effect: str, name: str, text: str, scope: dict[str, Any]) -> None:
        tree = _function(effect, text)
        renamed = {local: self._needed(effect, local, scope) for local in _foreign_names(tree)}
        self.parts[name] = ast.unparse(_Rename(renamed, name).visit(tree))

    def _needed(self, effect: str, local: str, scope: dict[str, Any]) -> str:
        """Bring along what a function finds in its file under the name ``local``; return its new name."""
        found = scope.get(local, getattr(builtins, local, None))
        if local == "math" or (local in ALLOWED and local not in scope):
            return local
        if isinstance(found, types.FunctionType):
            name = f"{found.__module__.replace('.', '_')}__{found.__name__}"
            if name not in self.parts:
                self._add(effect, name, _text(effect, found), found.__globals__)
            return name
        if isinstance(found, (bool, int, float)):
            name = f"{effect}__{local}"
            self.parts[name] = f"{name} = {found!r}"
            return name
        raise ModelError(
            f"the effect {effect} uses {local!r}; a hook may use math, numbers and functions of its own file"
        )


class _Rename(ast.NodeTransformer):
    def __init__(self, names: dict[str, str], function: str) -> None:
        self._names = names
        self._function = function

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        node.name = self._function
        node.returns = None
        node.decorator_list = []
        if ast.get_docstring(node) is not None and len(node.body) > 1:
            node.body = node.body[1:]
        self.generic_visit(node)
        return node

    def visit_arg(self, node: ast.arg) -> ast.arg:
        node.annotation = None
        return node

    def visit_Name(self, node: ast.Name) -> ast.Name:
        node.id = self._names.get(node.id, node.id)
        return node


def _text(effect: str, function: Callable[..., Any]) -> str:
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        name = getattr(function, "__name__", str(function))
        raise ModelError(
            f"the text of the hook {name!r} of the effect {effect} cannot be found; give it as source=..."
        ) from None


def _function(effect: str, text: str) -> ast.FunctionDef:
    body = parsed(textwrap.dedent(text)).body
    functions = [node for node in body if isinstance(node, ast.FunctionDef)]
    if len(functions) != 1:
        raise ModelError(f"a hook of the effect {effect} is not one plain function; write it as one def")
    return functions[0]


def _foreign_names(tree: ast.FunctionDef) -> list[str]:
    bound = {argument.arg for argument in tree.args.args}
    used: dict[str, None] = {}
    for statement in tree.body:
        for node in ast.walk(statement):
            if isinstance(node, ast.Name):
                if isinstance(node.ctx, ast.Store):
                    bound.add(node.id)
                else:
                    used[node.id] = None
    return [name for name in used if name not in bound]
