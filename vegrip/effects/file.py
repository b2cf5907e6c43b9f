"""Effects in files of their own, beside a recording or a model: read, and never more than an effect.

A model file may name such a file, and models come from other people. So its text is checked before anything
of it runs: imports of the contract, constants, plain functions over numbers and ``math``, and one ``EFFECT``.
"""

import ast
import dataclasses
import hashlib
import linecache
import types
from pathlib import Path

from vegrip.effects.contract import Effect
from vegrip.errors import InputError, ModelError
from vegrip.python_text import parsed

MAX_BYTES = 100_000
IMPORTS = {
    "vegrip.effects": {"Effect", "State", "hook"},
    "vegrip.parameters": {"Parameter"},
}
BUILTINS = {one.__name__: one for one in (abs, bool, float, int, max, min, range, round, tuple)}
SCALAR = (
    ast.Name, ast.Constant, ast.Attribute, ast.Call, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare,
    ast.IfExp, ast.Tuple, ast.keyword, ast.operator, ast.unaryop, ast.boolop, ast.cmpop, ast.expr_context,
)  # fmt: skip
FUNCTION = (
    *SCALAR, ast.FunctionDef, ast.arguments, ast.arg, ast.Assign, ast.AnnAssign, ast.AugAssign, ast.Return,
    ast.If, ast.For, ast.Break, ast.Continue, ast.Pass, ast.Expr, ast.Subscript,
)  # fmt: skip


def read_effect(path: Path) -> Effect:
    """Return the effect that is in the file ``path``."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not text in UTF-8"
        raise InputError(f"{path}: the effect cannot be read ({reason})") from None
    return dataclasses.replace(effect_of(text, str(path)), file=str(path.resolve()))


def effect_of(text: str, where: str) -> Effect:
    """Return the effect in ``text``; ``where`` names it in complaints."""
    if len(text) > MAX_BYTES:
        raise ModelError(f"{where}: is longer than {MAX_BYTES} characters; that is no effect")
    try:
        tree = parsed(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ModelError(f"{where}: is not Python ({error}); an effect file is") from None
    for statement in tree.body:
        _check(statement, where)
    name = f"effect_file_{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    file = f"<{name}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)  # for inspect.getsource
    module = types.ModuleType(name)
    module.__dict__["__builtins__"] = {**BUILTINS, "__import__": __import__}
    try:
        exec(compile(tree, file, "exec"), module.__dict__)  # noqa: S102 - nothing but what _check lets through
    except Exception as error:  # noqa: BLE001 - whatever is wrong with it is the author's to correct
        raise ModelError(f"{where}: the effect cannot be made ({error})") from None
    found = module.__dict__.get("EFFECT")
    if not isinstance(found, Effect):
        raise ModelError(f"{where}: holds no EFFECT; `vegrip new-effect NAME` writes one to begin with")
    return found


def _check(statement: ast.stmt, where: str) -> None:
    allowed: tuple[type[ast.AST], ...] = SCALAR
    if isinstance(statement, ast.Import | ast.ImportFrom):
        if not _is_known_import(statement):
            _refuse(statement, where)
        return
    if isinstance(statement, ast.FunctionDef) and not statement.decorator_list:
        allowed = FUNCTION
    elif isinstance(statement, ast.Assign) and all(isinstance(one, ast.Name) for one in statement.targets):
        allowed = (*SCALAR, ast.Assign)
    elif isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
        return
    else:
        _refuse(statement, where)
    in_function = isinstance(statement, ast.FunctionDef)
    for node in ast.walk(statement):
        is_strange = not isinstance(node, allowed)
        if isinstance(node, ast.Attribute):
            is_strange = not (isinstance(node.value, ast.Name) and node.value.id == "math")
            is_strange = is_strange or node.attr.startswith("_") or not isinstance(node.ctx, ast.Load)
        if isinstance(node, ast.Name | ast.FunctionDef | ast.arg):
            called = (
                node.id if isinstance(node, ast.Name) else getattr(node, "name", getattr(node, "arg", ""))
            )
            is_strange = is_strange or str(called).startswith("_")
            is_strange = is_strange or (
                called == "math" and not isinstance(getattr(node, "ctx", None), ast.Load)
            )
        if isinstance(node, ast.Call):
            is_strange = not isinstance(node.func, ast.Name | ast.Attribute)
        if isinstance(node, ast.BinOp) and not in_function:  # a power of powers takes for ever
            is_strange = True
        if is_strange:
            _refuse(node, where)


def _is_known_import(statement: ast.Import | ast.ImportFrom) -> bool:
    names = {one.name for one in statement.names}
    if any(one.asname for one in statement.names):
        return False
    if isinstance(statement, ast.Import):
        return names == {"math"}
    return not statement.level and names <= IMPORTS.get(statement.module or "", set())


def _refuse(node: ast.AST, where: str) -> None:
    raise ModelError(
        f"{where}: line {getattr(node, 'lineno', 1)} has what an effect in a file may not; it may import "
        "math, Effect, State, hook and Parameter, and define constants, functions over numbers and EFFECT"
    )
