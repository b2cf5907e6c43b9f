"""A whole module in C: the functions that its entries need, callees first, constants, tables and structs.

Small functions in C stand for those of Python's operators that C has with another meaning.
"""

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vegrip.c99 import literals, names
from vegrip.c99.expressions import Value, number_of
from vegrip.c99.functions import Body, Callees, Function
from vegrip.c99.kinds import (
    BOOL,
    DOUBLE,
    INT,
    ITEM_KIND,
    LONG,
    REAL,
    Kind,
    RealType,
    Record,
    Row,
    Struct,
    Table,
)  # fmt: skip
from vegrip.c99.scopes import nodes_of
from vegrip.python_text import parsed

LETTERS = {REAL: "r", INT: "i", LONG: "l", BOOL: "b"}


@dataclass(frozen=True)
class Program:
    """The text in C, in parts."""

    constants: tuple[str, ...]
    structs: tuple[str, ...]
    tables: tuple[str, ...]
    helpers: tuple[str, ...]
    functions: tuple[str, ...]
    calls: Mapping[str, frozenset[str]]
    """Name in C of each function -> those it calls."""

    def text(self) -> str:
        groups = (self.constants, self.structs, self.tables, self.helpers, self.functions)
        return "\n".join(part for group in groups if group for part in (*group, ""))


def translate(
    text: str,
    entries: Mapping[str, tuple[Kind, ...]],
    *,
    prefix: str = "vg",
    place: names.Place = names.unknown_place,
    notes: Mapping[str, str] | None = None,
    is_public: bool = True,
    outside: Mapping[str, Kind] | None = None,
    reals: RealType = DOUBLE,
) -> Program:
    """Translate what ``entries`` need.

    Args:
        text: the module; what it imports from numba is not looked at.
        entries: functions called from outside, with the kinds of their arguments.
        prefix: of every name that is made.
        place: says where a statement stands for its author.
        notes: texts for comments, by name of the function, where the module has no docstring.
        is_public: whether the entries are seen outside the file.
        outside: functions that are written in C already, and what they give; the text calls them without the
            prefix that they have in C.
        reals: the precision of real numbers.

    Raises:
        UntranslatableError: a line has no counterpart; names file and line.

    """
    translator = _Translator(text, set(entries) if is_public else set(), prefix, place, notes or {}, reals)
    translator.outside = dict(outside or {})
    for name, kinds in entries.items():
        for kind in kinds:
            translator.declare(kind)
        translator.function(name, kinds)
    return translator.program()


@dataclass
class _Done:
    name: str
    result: Kind
    text: str
    places: tuple[int, ...]  # of the parameters through which it writes
    calls: set[str] = field(default_factory=set)


class _Translator(Callees):
    def __init__(
        self,
        text: str,
        entries: set[str],
        prefix: str,
        place: names.Place,
        notes: Mapping[str, str],
        reals: RealType,
    ) -> None:
        tree = parsed(text)
        self.trees = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        self.values = _values(tree)
        self.entries, self.prefix, self.place, self.notes = entries, prefix, place, notes
        self.reals = reals
        self.done: dict[tuple[str, tuple[Kind, ...]], _Done] = {}
        self.places: dict[str, set[int]] = {}
        """Name of a function -> which parameters it writes through, whatever their kinds."""
        self.under_way: list[str] = []
        self.calling: list[set[str]] = []
        self.taken: set[str] = set()
        self.constants: dict[str, str] = {}
        self.structs: dict[tuple[Kind, ...], Struct] = {}
        self.records: dict[str, str] = {}
        self.outside: dict[str, Kind] = {}
        self.tables: dict[str, str] = {}
        self.helpers: dict[str, str] = {}

    def program(self) -> Program:
        return Program(
            tuple(self.constants.values()),
            (*self.records.values(), *(self._struct_text(struct) for struct in self.structs.values())),
            tuple(self.tables.values()),
            tuple(self.helpers.values()),
            tuple(one.text for one in self.done.values()),
            {one.name: frozenset(one.calls) for one in self.done.values()},
        )

    def declare(self, kind: Kind) -> None:
        """Declare a record, and those within it first."""
        if isinstance(kind, Row):
            self.declare(kind.item)
        if not isinstance(kind, Record) or kind.name in self.records:
            return
        for inner, _ in kind.fields.values():
            self.declare(inner)
        types = {
            name: self.reals.spelled(inner).removesuffix(" *") for name, (inner, _) in kind.fields.items()
        }
        lines = [
            f"    {types[name]} {name}{f'[{count}]' if _is_array(inner) else ''};"
            for name, (inner, count) in kind.fields.items()
        ]
        self.records[kind.name] = "\n".join(["typedef struct {", *lines, f"}} {kind.name};", ""])

    def function(self, name: str, kinds: tuple[Kind, ...]) -> _Done:
        """Translate a function, unless that is done."""
        key = (name, kinds)
        if key in self.done:
            return self.done[key]
        tree = self.trees[name]
        writer = Function(self, tree, kinds)
        self.under_way.append(name)
        self.calling.append(set())
        try:
            body = writer.body()
        except names.RefusedError as error:
            number = names.statements(tree).index(writer.at) if writer.at is not None else 0
            raise names.UntranslatableError(
                f"{self.place(name, number)}: {error}; this line cannot be translated to C"
            ) from None
        self.under_way.pop()
        self.done[key] = self._written(tree, kinds, body)
        self.done[key].calls = self.calling.pop()
        self.places.setdefault(name, set()).update(self.done[key].places)
        return self.done[key]

    def _written(self, tree: ast.FunctionDef, kinds: tuple[Kind, ...], body: Body) -> _Done:
        arguments = [argument.arg for argument in tree.args.args]
        name = self._free_name(tree.name, kinds)
        takes = [
            f"{'const ' if kind in ITEM_KIND and argument not in body.written else ''}"
            f"{self.reals.spelled(kind)}{'' if kind.c.endswith('*') else ' '}{names.local(argument)}"
            for argument, kind in zip(arguments, kinds, strict=True)
            if not isinstance(kind, Table)
        ]
        static = "" if tree.name in self.entries else "static "
        note = ast.get_docstring(tree) or self.notes.get(tree.name, "")
        lines = [
            *(names.comment(note) if note else []),
            *names.broken(f"{static}{self.reals.spelled(body.result)} {name}({', '.join(takes) or 'void'})"),
            "{",
            *body.lines,
            "}",
        ]
        places = tuple(i for i, argument in enumerate(arguments) if argument in body.written)
        return _Done(name, body.result, "\n".join(lines) + "\n", places)

    def _free_name(self, name: str, kinds: tuple[Kind, ...]) -> str:
        """Return a name in C; that of a repeated function says for what it is repeated."""
        tables = [kind.c.removeprefix(f"{self.prefix}_").lower() for kind in kinds if isinstance(kind, Table)]
        wanted = found = "_".join([names.joined(self.prefix, name), *tables])
        number = 1
        while found in self.taken:
            number += 1
            found = f"{wanted}_{number}"
        self.taken.add(found)
        return found

    # what a function asks for

    def called(self, node: ast.Call, name: str, kinds: tuple[Kind, ...]) -> tuple[str, Kind]:
        if name in self.outside:
            return names.joined(self.prefix, name), self.outside[name]
        if name not in self.trees:
            raise names.refused(node, "calls what is not in this module")
        if name in self.under_way:
            raise names.refused(node, "calls itself, in the end; recursion is not translated")
        if len(kinds) != len(self.trees[name].args.args):
            raise names.refused(node, "every argument is given; there are no default values")
        found = self.function(name, kinds)
        self.calling[-1].add(found.name)
        return found.name, found.result

    def writes(self, name: str) -> bool:
        return name in self.outside or bool(self.written(name))

    def written(self, name: str) -> tuple[int, ...]:
        if name in self.outside:
            return tuple(range(8))  # whatever it is given
        return tuple(self.places.get(name, ()))

    def struct(self, fields: tuple[Kind, ...]) -> Struct:
        if fields not in self.structs:
            letters = [LETTERS[kind] for kind in fields]
            is_uniform = len(set(letters)) == 1
            shape = f"{letters[0]}{len(letters)}" if is_uniform else "".join(letters)
            self.structs[fields] = Struct(f"{self.prefix}_{shape}", fields)
        return self.structs[fields]

    def helper(self, name: str) -> str:
        c = names.joined(self.prefix, name)
        if name not in self.helpers:
            self.taken.add(c)
            self.helpers[name] = helper(name, c, self.reals)
        return c

    def _struct_text(self, struct: Struct) -> str:
        fields = " ".join(f"{self.reals.spelled(kind)} v{i};" for i, kind in enumerate(struct.fields))
        return f"typedef struct {{ {fields} }} {struct.c};"

    def constant(self, node: ast.Name) -> Value:
        if node.id not in self.values:
            raise names.refused(node, "is not known here")
        value = self.values[node.id]
        c = names.joined(self.prefix.upper(), node.id)
        if isinstance(value, (bool, np.bool_)):
            self.constants[node.id] = f"#define {c} {'true' if value else 'false'}"
            return Value(c, BOOL, constant=bool(value))
        if isinstance(value, (int, np.integer)):
            self.constants[node.id] = f"#define {c} {number_of(node, int(value)).text}"
            return Value(c, number_of(node, int(value)).kind, constant=int(value))
        if isinstance(value, float):
            self.constants[node.id] = f"#define {c} {literals.real(value, self.reals)}"
            return Value(c, REAL, constant=float(value))
        return self._table(node, value, c)

    def _table(self, node: ast.Name, value: object, c: str) -> Value:
        try:
            kind, shape, text = literals.table(value, self.reals)
        except (ValueError, TypeError, OverflowError) as error:
            raise names.refused(node, f"is neither number nor table ({error})") from None
        sizes = "".join(f"[{n}]" for n in shape)
        head = f"static const {self.reals.spelled(kind)} {c}{sizes}"
        self.tables[node.id] = "\n".join(names.broken(f"{head} = {text};"))
        return Value(c, Table(c, shape, kind))


def _is_array(kind: Kind) -> bool:
    return isinstance(kind, Row) or kind in ITEM_KIND


def _values(tree: ast.Module) -> dict[str, object]:
    kept = [
        node
        for node in tree.body
        if not isinstance(node, ast.FunctionDef)
        and not any(isinstance(one, ast.Name) and one.id == "numba" for one in nodes_of(node))
        and not (isinstance(node, ast.Import) and any(one.name == "numba" for one in node.names))
    ]
    scope: dict[str, object] = {}
    exec(compile(ast.Module(kept, []), "<module>", "exec"), scope)  # noqa: S102 (a module that vegrip wrote)
    return {name: value for name, value in scope.items() if not name.startswith("__")}


EXTREME = """/* As Python's: the first, unless the second is {than}; NaN stays only as the first. */
static inline {type} {name}({type} a, {type} b)
{{
    return b {sign} a ? b : a;
}}
"""
FLOOR_DIV = """/* Division of whole numbers towards minus infinity. */
static inline {type} {name}({type} a, {type} b)
{{
    const {type} q = a / b;
    return a % b != 0 && (a < 0) != (b < 0) ? q - 1 : q;
}}
"""
MODULO = """/* Remainder with the sign of the divisor. */
static inline {type} {name}({type} a, {type} b)
{{
    const {type} r = a % b;
    return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}}
"""
HELPERS = {
    "max": EXTREME.replace("{than}", "greater").replace("{sign}", ">"),
    "min": EXTREME.replace("{than}", "less").replace("{sign}", "<"),
    "floor_div": FLOOR_DIV,
    "modulo": MODULO,
    "real_of_bits": """/* The number of an IEEE 754 single whose bits are given. */
static inline {real} {name}(int64_t bits)
{{
    union {{ uint32_t bits; float value; }} both;
    both.bits = (uint32_t)bits;
    return ({real})both.value;
}}
""",
    "bits_of_real": """/* The bits of the nearest IEEE 754 single; none is beyond the largest. */
static inline int64_t {name}({real} value)
{{
    union {{ uint32_t bits; float value; }} both;
    both.value = (float)value;
    return (int64_t)both.bits;
}}
""",
    "whole": """/* Towards zero; what does not fit into 32 bits, and NaN, gives 0. */
static inline int32_t {name}({real} x)
{{
    return x > -2147483648.0{literal} && x < 2147483648.0{literal} ? (int32_t)x : 0;
}}
""",
}
POWER = re.compile(r"power(\d+)")


def helper(kind: str, name: str, reals: RealType) -> str:
    if found := POWER.fullmatch(kind):
        return _power(int(found[1]), name, reals.c)
    kind_of_number = LONG.c if kind.endswith("_long") else INT.c
    if kind in ("max", "min"):
        kind_of_number = reals.c
    text = HELPERS[kind.removesuffix("_whole").removesuffix("_long")]
    return text.format(name=name, type=kind_of_number, real=reals.c, literal=reals.literal)


def _power(n: int, name: str, real: str) -> str:
    lines: list[str] = []
    exponent, product, square = n, "", "x"
    while exponent:
        if exponent & 1:
            product = f"{product} * {square}" if product else square
        exponent >>= 1
        if exponent:
            following = f"x{2 ** (len(lines) + 1)}"
            lines.append(f"    const {real} {following} = {square} * {square};")
            square = following
    return "\n".join(
        [f"static inline {real} {name}({real} x)", "{", *lines, f"    return {product};", "}", ""]
    )
