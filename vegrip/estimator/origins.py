"""Where the functions of a generated module were written: file, line and docstring, for those who read on."""

import ast
import functools
import inspect
import types
from collections.abc import Iterator, Sequence
from pathlib import Path

from vegrip.c99.names import statements
from vegrip.contact import limit_surface
from vegrip.effects.contract import Effect

HERE = Path(__file__).parent / "kernels"


class Origins:
    """The files behind a generated module."""

    def __init__(self, effects: Sequence[Effect], folders: Sequence[Path] = ()) -> None:
        self._hooks = dict(_hooks(effects))
        self._folders = (HERE, *folders)

    def place(self, function: str, number: int) -> str:
        """Return ``file:line`` of a function's statement; the name of the function where no file is known."""
        found = self._written(function)
        if found is None:
            return f"{function}, statement {number + 1}"
        path, tree = found
        inner = statements(tree)
        return f"{path}:{inner[number].lineno if number < len(inner) else tree.lineno}"

    def notes(self) -> dict[str, str]:
        return {name: inspect.getdoc(hook) or "" for name, hook in self._hooks.items()}

    def _written(self, function: str) -> tuple[Path, ast.FunctionDef] | None:
        if function in self._hooks:
            return _of_hook(self._hooks[function])
        return _kernel_functions(self._folders).get(function)


def _hooks(effects: Sequence[Effect]) -> Iterator[tuple[str, types.FunctionType]]:
    for effect in effects:
        for i, hook in enumerate(effect.hooks):
            function = hook.function
            if isinstance(function, types.FunctionType) and not hook.source:
                yield f"{effect.name}__{hook.stage}{i}", function
                for other in function.__globals__.values():
                    if isinstance(other, types.FunctionType):
                        yield f"{other.__module__.replace('.', '_')}__{other.__name__}", other


def _of_hook(function: types.FunctionType) -> tuple[Path, ast.FunctionDef] | None:
    path = Path(function.__code__.co_filename)
    first = function.__code__.co_firstlineno
    trees = _functions(path) if path.is_file() else []
    return next(((path, tree) for tree in trees if _begins(tree) == first), None)


def _begins(tree: ast.FunctionDef) -> int:
    return min([tree.lineno, *(one.lineno for one in tree.decorator_list)])


@functools.cache
def _kernel_functions(folders: tuple[Path, ...]) -> dict[str, tuple[Path, ast.FunctionDef]]:
    kernels = [path for folder in folders for path in sorted(folder.glob("*.py"))]
    files = [*kernels, Path(limit_surface.__file__).with_name("fast.py")]
    return {tree.name: (path, tree) for path in files for tree in _functions(path)}


@functools.cache
def _functions(path: Path) -> list[ast.FunctionDef]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
