"""Expressions: Python's in, C's out, with as few brackets as are needed to keep the order of operations."""

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from vegrip.c99 import literals
from vegrip.c99.kinds import (
    BOOL,
    BYTES,
    INT,
    ITEM_KIND,
    LONG,
    LONGS,
    NUMBERS,
    REAL,
    VOID,
    WHOLES,
    Kind,
    RealType,
    Record,
    Row,
    Struct,
    Table,
    common,
)  # fmt: skip
from vegrip.c99.names import local, refused
from vegrip.c99.scopes import nodes_of

MATHS = {
    name: name
    for name in (
        "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "copysign", "cos", "cosh", "erf", "erfc",
        "exp", "expm1", "fabs", "hypot", "log", "log10", "log1p", "log2", "pow", "sin", "sinh",
        "sqrt", "tan", "tanh",
    )
} | {"lgamma": "lgamma", "gamma": "tgamma"}  # fmt: skip
TESTS = ("isnan", "isfinite", "isinf")
WHOLE = ("floor", "ceil", "trunc")
CONSTANTS = {"inf": math.inf, "nan": math.nan, "pi": math.pi, "e": math.e, "tau": math.tau}
LARGEST_POWER = 64

CHOICE, EITHER, BOTH, BITS, EQUAL, LESS, SHIFT, SUM, PRODUCT, SIGN, ATOM = range(1, 12)
"""How tightly C binds; larger is tighter."""
BINARY = {ast.Add: ("+", SUM), ast.Sub: ("-", SUM), ast.Mult: ("*", PRODUCT), ast.Div: ("/", PRODUCT)}
BITWISE = {
    ast.BitAnd: ("&", BITS), ast.BitOr: ("|", BITS), ast.BitXor: ("^", BITS), ast.LShift: ("<<", SHIFT),
    ast.RShift: (">>", SHIFT),
}  # fmt: skip
"""Of whole numbers; their operands get brackets, for C's order differs from Python's."""
COMPARE = {
    ast.Lt: ("<", LESS), ast.LtE: ("<=", LESS), ast.Gt: (">", LESS), ast.GtE: (">=", LESS),
    ast.Eq: ("==", EQUAL), ast.NotEq: ("!=", EQUAL),
}  # fmt: skip


@dataclass(frozen=True)
class Value:
    """An expression in C: its text, its kind, and how tightly its outermost operator binds."""

    text: str
    kind: Kind
    binding: int = ATOM
    constant: int | float | None = None

    def within(self, binding: int) -> str:
        return self.text if self.binding >= binding else f"({self.text})"


class Module(Protocol):
    """What an expression finds outside its function."""

    reals: RealType

    def constant(self, node: ast.Name) -> Value:
        """Return a number or table of the module."""
        ...

    def called(self, node: ast.Call, name: str, kinds: tuple[Kind, ...]) -> tuple[str, Kind]:
        """Return name in C and result of a function of the module, for arguments of these kinds."""
        ...

    def struct(self, fields: tuple[Kind, ...]) -> Struct:
        """Return the struct for a tuple."""
        ...

    def helper(self, name: str) -> str:
        """Return the name in C of a small function that C99 lacks."""
        ...


@dataclass
class Expressions:
    """Writes the expressions of one function.

    With ``before`` a list, what touches the memory is put there as a statement of its own, in Python's order.
    """

    module: Module
    kinds: dict[str, Kind]
    temporary: Callable[[Kind, str], str]
    before: list[str] | None = None
    _guarded: int = field(default=0)

    def value(self, node: ast.expr) -> Value:
        """Return ``node`` in C.

        Raises:
            RefusedError: it has no counterpart.

        """
        writer: Callable[[ast.expr], Value] | None = getattr(self, f"_{type(node).__name__.lower()}", None)
        if writer is None:
            raise refused(node, f"{type(node).__name__} is outside the subset that is translated")
        return writer(node)

    def number(self, node: ast.expr) -> Value:
        """Return ``node``, which must be a number."""
        value = self.value(node)
        if value.kind not in NUMBERS:
            raise refused(node, "is not a number")
        return value

    def test(self, node: ast.expr) -> Value:
        """Return ``node``, which must be true or false."""
        value = self.value(node)
        if value.kind != BOOL:
            raise refused(node, "is a number where a comparison is needed")
        return value

    def index(self, node: ast.expr) -> str:
        """Return ``node``, which must be a whole number."""
        value = self.value(node)
        if value.kind not in WHOLES:
            raise refused(node, "is not a whole number")
        return value.text

    def place(self, node: ast.Subscript | ast.Attribute) -> str:
        """Return an element of the memory, or a field of a record, as something to assign to."""
        if isinstance(node, ast.Attribute):
            kind, text = self._member(node)
            if kind not in NUMBERS and not isinstance(kind, Record):
                raise refused(node, "an array is set element by element")
            return text
        memory = self.value(node.value)
        if memory.kind not in ITEM_KIND:
            raise refused(node, "only elements of the memory can be set")
        return f"{memory.text}[{self.index(node.slice)}]"

    def real(self, value: float) -> str:
        return literals.real(value, self.module.reals)

    def as_real(self, value: Value) -> str:
        return f"({self.module.reals.c}){value.within(SIGN)}"

    def of_math(self, function: str) -> str:
        return function + self.module.reals.function

    def stored(self, target: ast.Subscript | ast.Attribute, value: Value) -> str:
        """Return ``value`` as it is put into the memory at ``target``."""
        if isinstance(target, ast.Attribute):
            return self._stored_field(target, value)
        array = self.value(target.value).kind
        if array == LONGS and value.kind in (*WHOLES, BOOL):
            return value.text
        if ITEM_KIND[array] == LONG and value.kind in WHOLES:
            return f"(uint8_t){value.within(SIGN)}"
        if ITEM_KIND[array] == REAL and value.kind in (REAL, INT):
            return value.text
        if ITEM_KIND[array] == REAL and value.kind == BOOL:
            return f"{value.within(EITHER)} ? {self.real(1.0)} : {self.real(0.0)}"
        raise refused(target, f"holds {ITEM_KIND[array].c} and gets {value.kind.c}; convert it")

    def _stored_field(self, target: ast.Attribute, value: Value) -> str:
        kind, _ = self._member(target)
        if isinstance(kind, Record) and value.kind == kind:  # the whole is copied
            return value.text[1:] if value.text.startswith("&") else f"*{value.within(ATOM)}"
        if value.kind == kind or (kind in (LONG, REAL) and value.kind == INT):
            return value.text
        raise refused(target, f"holds {kind.c} and gets {value.kind.c}; convert it")

    def _member(self, node: ast.Attribute) -> tuple[Kind, str]:
        whole = self.value(node.value)
        if not isinstance(whole.kind, Record) or node.attr not in whole.kind.fields:
            raise refused(node, "is no field of a record, and no constant of math")
        kind, _ = whole.kind.fields[node.attr]
        if whole.text.startswith("&"):
            return kind, f"{whole.text[1:]}.{node.attr}"
        return kind, f"{whole.within(ATOM)}->{node.attr}"

    def _constant(self, node: ast.Constant) -> Value:
        value = node.value
        if isinstance(value, bool):
            return Value("true" if value else "false", BOOL, constant=value)
        if isinstance(value, int):
            return number_of(node, value)
        if isinstance(value, float):
            return Value(self.real(value), REAL, constant=value)
        raise refused(node, "only numbers are translated")

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.kinds:
            return Value(local(node.id), self.kinds[node.id])
        return self.module.constant(node)

    def _attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in CONSTANTS:
            value = CONSTANTS[node.attr]
            return Value(self.real(value), REAL, constant=value)
        kind, text = self._member(node)
        if isinstance(kind, Record):
            return Value(f"&{text}", kind, SIGN)
        return self.settled(Value(text, kind)) if kind in NUMBERS else Value(text, kind)

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(f"!{self.test(node.operand).within(SIGN)}", BOOL, SIGN)
        value = self.number(node.operand)
        if isinstance(node.op, ast.USub) and value.kind != BOOL:
            constant = None if value.constant is None else -value.constant
            return Value(f"-{value.within(ATOM)}", value.kind, SIGN, constant)
        raise refused(node, "this operator is not translated")

    def _binop(self, node: ast.BinOp) -> Value:
        left, right = self.number(node.left), self.number(node.right)
        if isinstance(node.op, ast.Pow):
            return self._power(node, left, right)
        kinds = {left.kind, right.kind}
        if kinds == {REAL, LONG}:
            raise refused(node, "mixes a real number with a whole one of 64 bits; write float(...)")
        kind = REAL if REAL in kinds else LONG if LONG in kinds else INT
        if type(node.op) in BITWISE:
            return self._bitwise(node, left, right, kind)
        if isinstance(node.op, (ast.FloorDiv, ast.Mod)):
            return self._whole_division(node, left, right, kind)
        if type(node.op) not in BINARY:
            raise refused(node, "this operator is not translated")
        sign, binding = BINARY[type(node.op)]
        a, b = left.within(binding), right.within(binding + 1)
        if sign == "/":
            a = a if left.kind == REAL else self.as_real(left)
            b = b if right.kind == REAL else self.as_real(right)
            kind = REAL
        return Value(f"{a} {sign} {b}", kind, binding)

    def _power(self, node: ast.BinOp, base: Value, exponent: Value) -> Value:
        """Write a power; a constant whole one as the products of squares that numba makes of it."""
        n = exponent.constant
        if exponent.kind == INT:
            if not isinstance(n, int) or not 0 < abs(n) <= LARGEST_POWER or base.kind != REAL:
                raise refused(node, f"whole powers are constant, 1 .. {LARGEST_POWER}, of a real number")
            product = f"{self.module.helper(f'power{abs(n)}')}({base.text})"
            return Value(product, REAL) if n > 0 else Value(f"{self.real(1.0)} / {product}", REAL, PRODUCT)
        if REAL not in {base.kind, exponent.kind}:
            raise refused(node, "a power of two whole numbers is not translated")
        return Value(f"{self.of_math('pow')}({base.text}, {exponent.text})", REAL)

    def _whole_division(self, node: ast.BinOp, left: Value, right: Value, kind: Kind) -> Value:
        if kind not in WHOLES:
            raise refused(node, "// and % are translated for whole numbers only")
        name = "floor_div" if isinstance(node.op, ast.FloorDiv) else "modulo"
        function = self.module.helper(f"{name}_long" if kind == LONG else name)
        return Value(f"{function}({left.text}, {right.text})", kind)

    def _bitwise(self, node: ast.BinOp, left: Value, right: Value, kind: Kind) -> Value:
        if kind not in WHOLES:
            raise refused(node, "bits are those of whole numbers")
        sign, binding = BITWISE[type(node.op)]
        if isinstance(node.op, ast.LShift) and kind == INT:  # as in numba, where it has 64 bits
            return Value(f"(int64_t){left.within(SIGN)} {sign} {right.within(SIGN)}", LONG, binding)
        return Value(f"{left.within(SIGN)} {sign} {right.within(SIGN)}", kind, binding)

    def _boolop(self, node: ast.BoolOp) -> Value:
        sign, binding = ("&&", BOTH) if isinstance(node.op, ast.And) else ("||", EITHER)
        first = self.test(node.values[0])
        self._guarded += 1
        tests = [first, *(self.test(value) for value in node.values[1:])]
        self._guarded -= 1
        # every compiler knows that && binds before ||, but they warn of it
        texts = [one.text if one.binding in (binding, ATOM) else one.within(EQUAL) for one in tests]
        return Value(f" {sign} ".join(texts), BOOL, binding)

    def _compare(self, node: ast.Compare) -> Value:
        sides = [self.number(side) for side in (node.left, *node.comparators)]
        if any(self._calls(side) for side in node.comparators[:-1]):
            raise refused(node, "give what stands in the middle a name first; it would be evaluated twice")
        parts = []
        for a, operator, b in zip(sides, node.ops, sides[1:], strict=False):
            if {a.kind, b.kind} == {REAL, LONG}:
                raise refused(node, "compares a real number with a whole one of 64 bits; write float(...)")
            if type(operator) not in COMPARE:
                raise refused(node, "this comparison is not translated")
            sign, binding = COMPARE[type(operator)]
            parts.append(f"{a.within(SUM)} {sign} {b.within(SUM)}")
        return Value(" && ".join(parts), BOOL, BOTH if len(parts) > 1 else binding)

    def _calls(self, node: ast.expr) -> bool:
        calls = (one.func for one in nodes_of(node) if isinstance(one, ast.Call))
        return any(isinstance(one, ast.Name) and not hasattr(self, f"_call_{one.id}") for one in calls)

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.test(node.test)
        self._guarded += 1
        yes, no = self.value(node.body), self.value(node.orelse)
        self._guarded -= 1
        kind = common(yes.kind, no.kind)
        if kind is None or kind == VOID:
            raise refused(node, "gives two kinds of value")
        texts = [self.converted(one, kind).within(EITHER) for one in (yes, no)]
        return Value(f"{test.within(EITHER)} ? {texts[0]} : {texts[1]}", kind, CHOICE)

    def converted(self, value: Value, kind: Kind) -> Value:
        """Return ``value`` as one of ``kind``; C does so by itself."""
        return Value(value.text, kind, value.binding)

    def _tuple(self, node: ast.Tuple) -> Value:
        values = [self.value(one) for one in node.elts]
        struct = self.module.struct(tuple(value.kind for value in values))
        return Value(f"({struct.c}){{{', '.join(value.text for value in values)}}}", struct)

    def _subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            return self._extent(node, node.value.value, node.slice)
        whole = self.value(node.value)
        if isinstance(whole.kind, Struct):
            i = self._field(node, whole.kind)
            return Value(f"{whole.within(ATOM)}.v{i}", whole.kind.fields[i])
        if isinstance(whole.kind, Table):
            return self._element(node, whole.kind)
        if isinstance(whole.kind, Row):
            return Value(f"&{whole.text}[{self.index(node.slice)}]", whole.kind.item, SIGN)
        if whole.kind not in ITEM_KIND:
            raise refused(node, "is neither memory, table nor tuple")
        item = f"{whole.text}[{self.index(node.slice)}]"
        if whole.kind == BYTES:  # a shift is not to be one of int
            return self.settled(Value(f"(int64_t){item}", LONG, SIGN))
        return self.settled(Value(item, ITEM_KIND[whole.kind]))

    def _element(self, node: ast.Subscript, table: Table) -> Value:
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(indices) != len(table.shape):
            raise refused(node, f"the table has {len(table.shape)} dimensions")
        return Value(table.c + "".join(f"[{self.index(one)}]" for one in indices), table.item)

    def _extent(self, node: ast.Subscript, table: ast.expr, axis: ast.expr) -> Value:
        found = self.value(table)
        if not isinstance(found.kind, Table) or not isinstance(axis, ast.Constant):
            raise refused(node, "only the shape of a constant table is known")
        return number_of(node, found.kind.shape[int(str(axis.value))])

    def _field(self, node: ast.Subscript, struct: Struct) -> int:
        try:
            place: int = range(len(struct.fields))[ast.literal_eval(node.slice)]
        except (ValueError, TypeError, IndexError):
            raise refused(node, "a tuple is taken apart by constant numbers only") from None
        return place

    def _call(self, node: ast.Call) -> Value:
        if node.keywords or any(isinstance(one, ast.Starred) for one in node.args):
            raise refused(node, "arguments are given by their place")
        match node.func:
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return self._math(node, name)
            case ast.Name(id=name):
                if hasattr(self, f"_call_{name}"):
                    written: Value = getattr(self, f"_call_{name}")(node)
                    return written
                return self._function(node, name)
        raise refused(node, "only functions of math and of the same file are called")

    def _function(self, node: ast.Call, name: str) -> Value:
        given = [self.value(one) for one in node.args]
        function, result = self.module.called(node, name, tuple(value.kind for value in given))
        passed = [value.text for value in given if not isinstance(value.kind, Table)]
        return self.settled(Value(f"{function}({', '.join(passed)})", result))

    def _math(self, node: ast.Call, name: str) -> Value:
        given = ", ".join(self.number(one).text for one in node.args)
        if name in MATHS:
            return Value(f"{self.of_math(MATHS[name])}({given})", REAL)
        if name in TESTS:
            return Value(f"({name}({given}) != 0)", BOOL)  # these macros give whole numbers
        if name in WHOLE:
            return Value(f"{self.module.helper('whole')}({self.of_math(name)}({given}))", INT)
        raise refused(node, f"math.{name} has no counterpart in C99 that is known here")

    def _call_max(self, node: ast.Call) -> Value:
        return self._extreme(node, "max")

    def _call_min(self, node: ast.Call) -> Value:
        return self._extreme(node, "min")

    def _extreme(self, node: ast.Call, name: str) -> Value:
        values = [self.number(one) for one in node.args]
        if len(values) < 2:
            raise refused(node, "needs two numbers")
        kinds = {value.kind for value in values}
        kind = REAL if REAL in kinds else LONG if LONG in kinds else INT
        if kinds >= {REAL, LONG}:
            raise refused(node, "mixes a real number with a whole one of 64 bits; write float(...)")
        function = self.module.helper(name + {INT: "_whole", LONG: "_long"}.get(kind, ""))
        text = values[0].text
        for other in values[1:]:
            text = f"{function}({text}, {other.text})"
        return Value(text, kind)

    def _call_abs(self, node: ast.Call) -> Value:
        value = self.number(node.args[0])
        if value.kind != REAL:
            raise refused(node, "abs is translated for real numbers only")
        return Value(f"{self.of_math('fabs')}({value.text})", REAL)

    def _call_float(self, node: ast.Call) -> Value:
        value = self.number(node.args[0])
        return value if value.kind == REAL else Value(self.as_real(value), REAL, SIGN)

    def _call_int(self, node: ast.Call) -> Value:
        value = self.number(node.args[0])
        if value.kind in WHOLES:
            return value
        if value.kind == BOOL:
            return Value(f"{value.within(EITHER)} ? 1 : 0", INT, CHOICE)
        return Value(f"{self.module.helper('whole')}({value.text})", INT)

    def _call_real_of_bits(self, node: ast.Call) -> Value:
        bits = self.index(node.args[0])
        return Value(f"{self.module.helper('real_of_bits')}({bits})", REAL)

    def _call_bits_of_real(self, node: ast.Call) -> Value:
        value = self.number(node.args[0])
        return Value(f"{self.module.helper('bits_of_real')}({value.text})", LONG)

    def _call_round(self, node: ast.Call) -> Value:
        if len(node.args) != 1:
            raise refused(node, "round is translated to whole numbers only")
        rounded = f"{self.of_math('rint')}({self.number(node.args[0]).text})"
        return Value(f"{self.module.helper('whole')}({rounded})", INT)

    def _call_bool(self, node: ast.Call) -> Value:
        value = self.number(node.args[0])
        return value if value.kind == BOOL else Value(f"{value.within(SUM)} != 0", BOOL, EQUAL)

    def _call_len(self, node: ast.Call) -> Value:
        found = self.value(node.args[0])
        if isinstance(found.kind, Table):
            return number_of(node, found.kind.shape[0])
        raise refused(node, "only the length of a constant table is known")

    def settled(self, value: Value) -> Value:
        """Give what touches the memory a name of its own where the order of evaluation matters."""
        if self.before is None or value.kind == VOID:
            return value
        if self._guarded:
            raise refused(
                ast.Name(value.text), "is evaluated in an order that C does not fix; give it a name first"
            )
        return Value(self.temporary(value.kind, value.text), value.kind)


def number_of(node: ast.expr, value: int) -> Value:
    try:
        return Value(literals.whole(value), INT if literals.is_short(value) else LONG, constant=value)
    except OverflowError as error:
        raise refused(node, str(error)) from None
