"""A generated module of vegrip, statement by statement in C: the limit that compiled Python is held against.

Generated modules are scalar code on one array (:mod:`vegrip.model.writer`), so every statement has one
counterpart in C. Types are found by going through each function with those of its arguments; a function that
is called with others is written again. What a generated module does not use is not translated.
"""

import ast
import ctypes
import subprocess
from pathlib import Path
from types import ModuleType

import numpy as np

FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC")
"""Without fused multiplication and addition, which rounds once where numba rounds twice."""

POINTER, INT, FLOAT, BOOL = "double *", "long", "double", "int"
MATHS = {"lgamma", "expm1", "hypot", "erfc", "sqrt", "exp", "log", "sin", "cos", "atan2", "sinh", "copysign"}
TESTS = {"isnan", "isfinite"}
BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Mod: "%", ast.FloorDiv: "/"}
COMPARE = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
HEAD = """#include <math.h>
static inline double least(double a, double b) { return b < a ? b : a; }
static inline double most(double a, double b) { return b > a ? b : a; }
static inline long least_i(long a, long b) { return b < a ? b : a; }
static inline long most_i(long a, long b) { return b > a ? b : a; }
"""

Text = tuple[str, str]  # of an expression, and its type


def compiled(module: ModuleType, entry: str, arguments: tuple[str, ...], folder: Path) -> ctypes.CDLL:
    """Translate ``entry`` of the plain ``module``; build it in a loop, ``ENTRY_many(count, ...)``."""
    program = Program(module)
    name, result = program.function(entry, arguments)
    names = [f"a{i}" for i in range(len(arguments))]
    takes = ", ".join(f"{kind} {one}" for kind, one in zip(arguments, names, strict=True))
    loop = f"for (long i = 0; i < count; i++) {name}({', '.join(names)});"
    text = f"{program.text()}\nvoid {entry}_many(long count, {takes}) {{ {loop} }}\n"
    assert result == "void"
    source, library = folder / "step.c", folder / "step.so"
    source.write_text(text, encoding="utf-8")
    command = ["cc", *FLAGS, "-w", str(source), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


class Program:
    """The functions translated so far."""

    def __init__(self, module: ModuleType) -> None:
        self.module = module
        tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
        self.trees = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        self.known: dict[tuple[str, tuple[str, ...]], Text] = {}
        self.parts: list[str] = []
        self.constants: dict[str, str] = {}
        self.tuples: dict[tuple[str, ...], str] = {}

    def text(self) -> str:
        """Return everything needed, in order."""
        structs = [
            f"typedef struct {{ {' '.join(f'{kind} f{i};' for i, kind in enumerate(kinds))} }} {name};"
            for kinds, name in self.tuples.items()
        ]
        return "\n".join([HEAD, *structs, *self.constants.values(), *self.parts])

    def function(self, name: str, arguments: tuple[str, ...]) -> Text:
        """Return the C name and the type of the result of a function called with these types."""
        key = (name, arguments)
        if key not in self.known:
            self.known[key] = Function(self, self.trees[name], arguments).written(f"{name}_{len(self.known)}")
        return self.known[key]

    def constant(self, name: str) -> Text:
        """Return a module's number as text, or the name of its array, declared once."""
        value = getattr(self.module, name)
        if isinstance(value, (bool, np.bool_)):
            return str(int(value)), BOOL
        if isinstance(value, (int, np.integer)):
            return str(int(value)), INT
        if isinstance(value, float):
            return _float(value), FLOAT
        kind, items = _array(value)
        shape = "".join(f"[{n}]" for n in np.shape(value))
        self.constants[name] = f"static const {kind} {name}{shape} = {items};"
        return name, f"array {name}"

    def tuple_type(self, kinds: tuple[str, ...]) -> str:
        """Return the struct for a tuple."""
        return self.tuples.setdefault(kinds, f"Tuple{len(self.tuples)}")

    def fields(self, struct: str) -> tuple[str, ...]:
        """Return the types of a struct's fields."""
        return next(kinds for kinds, name in self.tuples.items() if name == struct)


class Function:
    """One function with the types of its arguments."""

    def __init__(self, program: Program, tree: ast.FunctionDef, arguments: tuple[str, ...]) -> None:
        self.program, self.tree = program, tree
        self.names = [argument.arg for argument in tree.args.args]
        self.types = dict(zip(self.names, arguments, strict=True))
        self.result = "void"
        self.count = 0

    def written(self, name: str) -> Text:
        """Write the function: once more while a pass still finds another type."""
        while True:
            before = (dict(self.types), self.result)
            self.count = 0
            body = self.block(self.tree.body)
            if before == (self.types, self.result):
                break
        kept = [one for one in self.names if not self.types[one].startswith("array ")]
        takes = ", ".join(f"{self.types[one]} {one}" for one in kept)
        locals_ = "".join(
            f" {kind} {one};"
            for one, kind in self.types.items()
            if one not in self.names and not kind.startswith("array ")
        )
        self.program.parts.append(f"static {self.result} {name}({takes}) {{{locals_}\n{body}\n}}")
        return name, self.result

    def block(self, statements: list[ast.stmt]) -> str:
        return "\n".join(self.statement(statement) for statement in statements)

    def statement(self, node: ast.stmt) -> str:  # noqa: PLR0911 (a case each)
        match node:
            case ast.Assign(targets=targets, value=value):
                return " ".join(self.assign(target, value) for target in targets)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                return self.assign(target, value)
            case ast.AugAssign(target=target, op=operator, value=value):
                left = ast.parse(ast.unparse(target), mode="eval").body
                return self.assign(target, ast.BinOp(left, operator, value))
            case ast.If():
                other = f" else {{\n{self.block(node.orelse)}\n}}" if node.orelse else ""
                return f"if ({self.expression(node.test)[0]}) {{\n{self.block(node.body)}\n}}{other}"
            case ast.While():
                return f"while ({self.expression(node.test)[0]}) {{\n{self.block(node.body)}\n}}"
            case ast.For():
                return self.loop(node)
            case ast.Return(value=None):
                return "return;"
            case ast.Return(value=ast.expr() as value):
                text, self.result = self.expression(value)
                return f"return {text};"
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return ""
            case ast.Expr(value=value):
                return f"{self.expression(value)[0]};"
            case ast.Break():
                return "break;"
            case ast.Continue():
                return "continue;"
        raise NotImplementedError(ast.unparse(node))

    def assign(self, target: ast.expr, value: ast.expr) -> str:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            return self.apart(target.elts, [self.expression(one) for one in value.elts])
        text, kind = self.expression(value)
        if isinstance(target, ast.Tuple):
            whole = f"t{self.count}_"
            self.count += 1
            self.types[whole] = kind
            fields = [(f"{whole}.f{i}", one) for i, one in enumerate(self.program.fields(kind))]
            return f"{whole} = {text}; {self.apart(target.elts, fields)}"
        return self.store(target, text, kind)

    def apart(self, targets: list[ast.expr], values: list[Text]) -> str:
        """Assign several at once: all values are taken before any target changes."""
        taken = []
        for _, kind in values:
            taken.append(f"s{self.count}_")
            self.count += 1
            self.types[taken[-1]] = kind
        first = " ".join(f"{name} = {text};" for name, (text, _) in zip(taken, values, strict=True))
        stores = [
            self.store(target, name, self.types[name]) for target, name in zip(targets, taken, strict=True)
        ]
        return f"{first} {' '.join(stores)}"

    def store(self, target: ast.expr, text: str, kind: str) -> str:
        if isinstance(target, ast.Name):
            before = self.types.get(target.id, kind)
            self.types[target.id] = FLOAT if {before, kind} == {INT, FLOAT} else before
            return f"{target.id} = {text};"
        return f"{self.expression(target)[0]} = {text};"

    def loop(self, node: ast.For) -> str:
        assert isinstance(node.target, ast.Name)
        name, body = node.target.id, node.body
        if isinstance(node.iter, ast.Tuple):  # written out
            self.types[name] = INT
            each = [f"{name} = {self.expression(one)[0]};\n{self.block(body)}" for one in node.iter.elts]
            return "\n".join(each)
        if not isinstance(node.iter, ast.Call):  # over a constant tuple
            array, _ = self.expression(node.iter)
            length = len(getattr(self.program.module, array))
            index = f"i{self.count}_"
            self.count += 1
            self.types[index], self.types[name] = INT, FLOAT
            head = f"for ({index} = 0; {index} < {length}; {index}++)"
            return f"{head} {{ {name} = {array}[{index}];\n{self.block(body)}\n}}"
        limits = [self.expression(one)[0] for one in node.iter.args]
        first, last = (["0", *limits] if len(limits) == 1 else limits)[:2]
        step = limits[2] if len(limits) == 3 else "1"
        self.types[name] = INT
        counter = f"i{self.count}_"  # the body may assign to the name, which the loop does not look at
        self.count += 1
        self.types[counter] = INT
        test = ">" if step.startswith("(-") else "<"
        head = f"for ({counter} = {first}; {counter} {test} {last}; {counter} += {step})"
        return f"{head} {{ {name} = {counter};\n{self.block(body)}\n}}"

    def expression(self, node: ast.expr) -> Text:  # noqa: PLR0911, PLR0912 (a case each)
        match node:
            case ast.Constant(value=value):
                if isinstance(value, bool):
                    return str(int(value)), BOOL
                return (str(value), INT) if isinstance(value, int) else (_float(float(str(value))), FLOAT)
            case ast.Name(id=name):
                if name not in self.types:
                    return self.program.constant(name)
                kind = self.types[name]
                return (kind.removeprefix("array ") if kind.startswith("array ") else name), kind
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return {"inf": "INFINITY", "nan": "NAN", "pi": "3.14159265358979323846"}[name], FLOAT
            case ast.UnaryOp(op=operator, operand=operand):
                text, kind = self.expression(operand)
                sign = {ast.USub: "-", ast.UAdd: "", ast.Not: "!"}[type(operator)]
                return f"({sign}{text})", BOOL if sign == "!" else kind
            case ast.BinOp(left=left, op=operator, right=right):
                return self.binary(operator, self.expression(left), self.expression(right))
            case ast.BoolOp(op=operator, values=values):
                sign = " && " if isinstance(operator, ast.And) else " || "
                return f"({sign.join(self.expression(one)[0] for one in values)})", BOOL
            case ast.Compare():
                sides = [self.expression(one)[0] for one in (node.left, *node.comparators)]
                pairs = zip(sides, node.ops, sides[1:], strict=False)
                return f"({' && '.join(f'{a} {COMPARE[type(op)]} {b}' for a, op, b in pairs)})", BOOL
            case ast.IfExp():
                test, yes, no = (self.expression(one) for one in (node.test, node.body, node.orelse))
                kind = FLOAT if FLOAT in {yes[1], no[1]} else yes[1]
                return f"({test[0]} ? {yes[0]} : {no[0]})", kind
            case ast.Tuple(elts=parts):
                found = [self.expression(one) for one in parts]
                struct = self.program.tuple_type(tuple(kind for _, kind in found))
                return f"({struct}){{{', '.join(text for text, _ in found)}}}", struct
            case ast.Subscript():
                return self.element(node)
            case ast.Call():
                return self.call(node)
        raise NotImplementedError(ast.unparse(node))

    def binary(self, operator: ast.operator, left: Text, right: Text) -> Text:
        (a, kind), (b, other) = left, right
        if isinstance(operator, ast.Pow):
            if other == INT and b.isdigit() and kind == FLOAT:
                return self.power(a, int(b)), FLOAT
            return f"pow({a}, {b})", FLOAT
        if isinstance(operator, ast.Div):
            return f"((double){a} / {b})", FLOAT
        return f"({a} {BINARY[type(operator)]} {b})", FLOAT if FLOAT in {kind, other} else INT

    def power(self, base: str, exponent: int) -> str:
        """Write a constant whole power as numba does: products of squares, not ``pow``."""
        square, product = f"q{self.count}_", f"p{self.count}_"
        self.count += 1
        self.types[square] = self.types[product] = FLOAT
        steps = [f"{square} = {base}", f"{product} = 1.0"]
        while exponent:
            steps += [f"{product} *= {square}"] if exponent & 1 else []
            exponent >>= 1
            steps += [f"{square} *= {square}"] if exponent else []
        return f"({', '.join(steps)}, {product})"

    def element(self, node: ast.Subscript) -> Text:
        if isinstance(node.value, ast.Attribute):  # table.shape[0]
            array = self.expression(node.value.value)[0]
            axis = ast.literal_eval(node.slice)
            return str(getattr(self.program.module, array).shape[axis]), INT
        text, kind = self.expression(node.value)
        if kind.startswith("Tuple"):
            i = ast.literal_eval(node.slice)
            return f"{text}.f{i}", self.program.fields(kind)[i]
        if isinstance(node.slice, ast.Tuple):
            index = "][".join(self.expression(one)[0] for one in node.slice.elts)
            return f"{text}[{index}]", FLOAT
        inside = FLOAT if kind == POINTER else _array(getattr(self.program.module, text))[0]
        return f"{text}[{self.expression(node.slice)[0]}]", inside

    def call(self, node: ast.Call) -> Text:  # noqa: PLR0911 (a case each)
        given = [self.expression(one) for one in node.args]
        texts, kinds = [text for text, _ in given], [kind for _, kind in given]
        joined = ", ".join(texts)
        match node.func:
            case ast.Attribute(attr=name) if name in MATHS:
                return f"{name}({joined})", FLOAT
            case ast.Attribute(attr=name) if name in TESTS:
                return f"{name}({joined})", BOOL
            case ast.Name(id="max" | "min" as name):
                whole = set(kinds) <= {INT, BOOL}
                function = {"max": "most", "min": "least"}[name] + ("_i" if whole else "")
                text = texts[0]
                for other in texts[1:]:
                    text = f"{function}({text}, {other})"
                return text, INT if whole else FLOAT
            case ast.Name(id="abs"):
                return f"fabs({joined})", FLOAT
            case ast.Name(id="float"):
                return f"((double){joined})", FLOAT
            case ast.Name(id="bool"):
                return f"({joined} != 0)", BOOL
            case ast.Name(id="int"):
                return f"((long){joined})", INT
            case ast.Name(id="len"):
                return str(len(getattr(self.program.module, texts[0]))), INT
            case ast.Name(id=name):
                function, result = self.program.function(name, tuple(kinds))
                passed = [text for text, kind in given if not kind.startswith("array ")]
                return f"{function}({', '.join(passed)})", result
        raise NotImplementedError(ast.unparse(node))


def _float(value: float) -> str:
    return repr(value) if np.isfinite(value) else ("INFINITY" if value > 0 else "-INFINITY")


def _array(value: object) -> tuple[str, str]:
    """Element type and initialiser of a tuple or array."""
    array = np.asarray(value)
    kind = FLOAT if array.dtype.kind == "f" else INT
    return kind, str(array.tolist()).translate(str.maketrans("[]", "{}")).replace("True", "1").replace(
        "False", "0"
    )
