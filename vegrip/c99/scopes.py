"""Where the local variables of a function are declared, and which order of evaluation C leaves open.

A variable is declared with its first value, as far inside as can be. The order of operands matters only where
one writes to the memory and another reads it: Python fixes it, C does not.
"""

import ast
from collections import Counter
from collections.abc import Callable


def nodes_of(tree: ast.AST) -> tuple[ast.AST, ...]:
    """Return ``tree`` and everything below it; the tree must not change from then on."""
    try:
        known: tuple[ast.AST, ...] = tree.__dict__["nodes_found"]
    except KeyError:
        found = [tree]
        for name in tree._fields:
            value = getattr(tree, name, None)
            for one in value if type(value) is list else (value,):
                if isinstance(one, ast.AST):
                    found += nodes_of(one)
        known = tree.__dict__["nodes_found"] = tuple(found)
    return known


Home = tuple[int, int]
"""A list of statements, by its id, and the number of the statement in it."""


class Scopes:
    """Homes of the local variables.

    A variable that begins anew in several blocks has a home in each; a variable without a home is declared
    at the top of the function.
    """

    def __init__(self, tree: ast.FunctionDef) -> None:
        self._arguments = {argument.arg for argument in tree.args.args}
        names = [node for node in nodes_of(tree) if isinstance(node, ast.Name)]
        self._reads = {node.id for node in names if isinstance(node.ctx, ast.Load)}
        self._stores = Counter(node.id for node in names if isinstance(node.ctx, ast.Store))
        self._homes: dict[str, dict[Home, bool]] = {}
        self._loops: dict[str, set[int]] = {}
        self._seen: dict[int, set[str]] = {}
        for name in {node.id for node in names} - self._arguments:
            homes: dict[Home, bool] = {}
            loops: set[int] = set()
            if self._find_homes(tree.body, name, homes, loops):
                self._homes[name], self._loops[name] = homes, loops

    def is_read(self, name: str) -> bool:
        return name in self._reads

    def is_fixed(self, name: str) -> bool:
        return self._stores[name] == (0 if name in self._arguments else 1)

    def has_home(self, name: str) -> bool:
        return name in self._homes

    def is_declared_in(self, name: str, home: Home) -> bool:
        return home in self._homes.get(name, {})

    def is_constant(self, name: str, home: Home) -> bool:
        return self._homes[name][home]

    def is_owned_by(self, name: str, loop: ast.For) -> bool:
        return id(loop) in self._loops.get(name, set())

    def _find_homes(self, body: list[ast.stmt], name: str, homes: dict[Home, bool], loops: set[int]) -> bool:
        """Find the homes of ``name`` in a list of statements; False when a use has none."""
        for number, node in enumerate(body):
            if not self._mentions(node, name):
                continue
            if self._begins(node, name):
                homes[id(body), number] = sum(_stores(one, name) for one in body) == 1
                return True
            if isinstance(node, ast.For) and self._mentions(node.target, name):
                if self._mentions(node.iter, name) or any(_stores(one, name) for one in node.body):
                    return False
                loops.add(id(node))
                continue
            if any(self._mentions(part, name) for part in ast.iter_child_nodes(node) if _is_expression(part)):
                return False
            if not all(
                self._find_homes(getattr(node, part, []), name, homes, loops) for part in ("body", "orelse")
            ):
                return False
        return True

    def _begins(self, node: ast.stmt, name: str) -> bool:
        target: ast.expr
        value: ast.expr | None
        if isinstance(node, ast.AnnAssign):
            target, value = node.target, node.value
        elif isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = node.targets[0], node.value
        else:
            return False
        parts = target.elts if isinstance(target, ast.Tuple) else [target]
        sets = [part for part in parts if isinstance(part, ast.Name) and part.id == name]
        others = [part for part in parts if part not in sets]
        reads = [one for one in (value, *others) if one is not None and self._mentions(one, name)]
        return len(sets) == 1 and value is not None and not reads

    def _mentions(self, node: ast.AST, name: str) -> bool:
        if id(node) not in self._seen:
            self._seen[id(node)] = {one.id for one in nodes_of(node) if isinstance(one, ast.Name)}
        return name in self._seen[id(node)]


def _is_expression(node: ast.AST) -> bool:
    return isinstance(node, ast.expr)


def _stores(node: ast.AST, name: str) -> int:
    return sum(
        isinstance(one, ast.Name) and one.id == name and isinstance(one.ctx, ast.Store)
        for one in nodes_of(node)
    )


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
    return isinstance(node, ast.Attribute) and not (
        isinstance(node.value, ast.Name) and node.value.id == "math"
    )


def _writes(node: ast.expr, writes: Writes) -> bool:
    return any(isinstance(inner, ast.Call) and writes(inner) for inner in nodes_of(node))
