"""One function: its statements, and what each of its variables holds."""

import ast
from dataclasses import dataclass

from vegrip.c99.expressions import LESS, Expressions, Module, Value
from vegrip.c99.kinds import (
    BOOL,
    INT,
    ITEM_KIND,
    LONG,
    REAL,
    VOID,
    WHOLES,
    Kind,
    Record,
    Row,
    Struct,
    Table,
    common,
)  # fmt: skip
from vegrip.c99.literals import real
from vegrip.c99.names import INDENT, broken, is_text, local, refused
from vegrip.c99.scopes import Scopes, is_field, matters, nodes_of
from vegrip.python_text import parsed

ZERO = {INT: "0", LONG: "0", BOOL: "false"}
PASSES = 8  # until the kinds of all variables are known


@dataclass(frozen=True)
class Body:
    """A translated function, without its head."""

    lines: tuple[str, ...]
    result: Kind
    written: frozenset[str]  # parameters through which it writes to the memory


class Function:
    """Writes a function for arguments of given kinds."""

    def __init__(self, module: "Callees", tree: ast.FunctionDef, kinds: tuple[Kind, ...]) -> None:
        self.module, self.tree = module, tree
        self.arguments = [argument.arg for argument in tree.args.args]
        self.kinds = dict(zip(self.arguments, kinds, strict=True))
        self.scopes = Scopes(tree)
        self.result: Kind | None = None
        self.written: set[str] = set()
        self.at: ast.stmt | None = None
        """The statement in work."""

    def body(self) -> Body:
        """Translate; again, until no statement adds to the kinds of the variables.

        Raises:
            RefusedError: a statement has no counterpart; :attr:`at` is that statement.

        """
        for number in range(PASSES):
            before = (dict(self.kinds), self.result, set(self.written))
            lines = self._whole()
            # at the second look it is known which of the functions called write to the memory
            if number > 0 and before == (self.kinds, self.result, self.written):
                break
        return Body(tuple(lines), self.result or VOID, frozenset(self.written))

    def _whole(self) -> list[str]:
        self.names: set[str] = {*self.kinds, *(n.id for n in nodes_of(self.tree) if isinstance(n, ast.Name))}
        self.made = 0
        unused = [f"(void){local(name)};" for name in self.arguments if self._is_unused(name)]
        lines = self._block(self.tree.body)
        return [line for one in [*self._declarations(), *unused, *lines] for line in broken(INDENT + one)]

    def _is_unused(self, name: str) -> bool:
        return not isinstance(self.kinds[name], Table) and not self.scopes.is_read(name)

    def spelled(self, kind: Kind) -> str:
        return self.module.reals.spelled(kind)

    def _nothing(self, kind: Kind) -> str:
        if isinstance(kind, Struct):
            return f"{{{', '.join(map(self._nothing, kind.fields))}}}"
        if isinstance(kind, Record):
            return "0"
        return real(0.0, self.module.reals) if kind == REAL else ZERO[kind]

    def _declared(self, kind: Kind, name: str, *, is_constant: bool) -> str:
        """Return the declaration of a variable; a record is pointed to."""
        if isinstance(kind, Record):
            return f"{kind.c}{'const ' if is_constant else ''}{local(name)}"
        return f"{'const ' if is_constant else ''}{self.spelled(kind)} {local(name)}"

    def _declarations(self) -> list[str]:
        return [
            f"{self._declared(kind, name, is_constant=False)} = {self._nothing(kind)};"
            for name, kind in self.kinds.items()
            if name not in self.arguments and self.scopes.is_read(name) and not self.scopes.has_home(name)
        ]

    def _block(self, body: list[ast.stmt]) -> list[str]:
        lines: list[str] = []
        for number, node in enumerate(body):
            if is_text(node) or isinstance(node, ast.Pass):
                continue
            self.at, self.where = node, (id(body), number)
            lines += self._statement(node)
        return lines

    def _inside(self, body: list[ast.stmt]) -> list[str]:
        at, where = self.at, self.where
        lines = [INDENT + line for line in self._block(body)]
        self.at, self.where = at, where
        return lines

    def _statement(self, node: ast.stmt) -> list[str]:  # noqa: PLR0911 (a case each)
        match node:
            case ast.Assign(targets=targets, value=value):
                return self._assign(targets, value)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                return self._assign([target], value)
            case ast.AugAssign():
                return self._augmented(node)
            case ast.If():
                return self._if(node)
            case ast.While(orelse=[]):
                return [
                    f"while ({self._ahead(node.test).test(node.test).text}) {{",
                    *self._inside(node.body),
                    "}",
                ]
            case ast.For(orelse=[]):
                return self._for(node)
            case ast.Return():
                return self._return(node)
            case ast.Expr(value=ast.Call() as call):
                return self._evaluated(call)
            case ast.Break():
                return ["break;"]
            case ast.Continue():
                return ["continue;"]
        raise refused(node, f"{type(node).__name__} is outside the subset that is translated")

    def _writer(self, *nodes: ast.expr) -> Expressions:
        """Return the writer of a statement's expressions; one that keeps Python's order where it matters."""
        within = ast.Tuple(list(nodes), ast.Load())
        ordered = matters(within, self._writes)
        writer = Expressions(self.module, self.kinds, self._temporary, [] if ordered else None)
        self.before = writer.before if writer.before is not None else []
        return writer

    def _ahead(self, node: ast.expr) -> Expressions:
        if matters(node, self._writes):
            raise refused(node, "is evaluated in an order that C does not fix; give its parts names first")
        return self._writer(node)

    def _writes(self, call: ast.Call) -> bool:
        return isinstance(call.func, ast.Name) and self.module.writes(call.func.id)

    def _temporary(self, kind: Kind, text: str) -> str:
        name = self._fresh("t")
        self.before.append(f"{self._declared(kind, name, is_constant=True)} = {text};")
        return name

    def _fresh(self, stem: str) -> str:
        while True:
            self.made += 1
            name = f"{stem}{self.made}"
            if name not in self.names:
                return name

    def _evaluated(self, call: ast.Call) -> list[str]:
        writer = self._writer(call)
        value = writer.value(call)
        self._note_writes(call)
        text = value.text if value.kind == VOID else f"(void){value.text}"
        return [*self.before, f"{text};"]

    def _note_writes(self, *nodes: ast.expr) -> None:
        for call in (one for node in nodes for one in nodes_of(node) if isinstance(one, ast.Call)):
            if isinstance(call.func, ast.Name):
                for place in self.module.written(call.func.id):
                    if place < len(call.args):
                        self._note_written(call.args[place])

    def _note_written(self, node: ast.expr) -> None:
        """Note that ``node`` is written to: a parameter, or, by whatever name, some record."""
        if isinstance(node, ast.Name) and not isinstance(self.kinds.get(node.id), Record):
            self.written.add(node.id)
        else:
            self.written |= {name for name in self.arguments if isinstance(self.kinds[name], Record)}

    def _assign(self, targets: list[ast.expr], value: ast.expr) -> list[str]:
        self._note_writes(value, *targets)
        if len(targets) == 1 and isinstance(targets[0], ast.Tuple):
            return self._apart(targets[0].elts, value)
        writer = self._writer(value, *(target for target in targets if not isinstance(target, ast.Name)))
        found = writer.value(value)
        if len(targets) > 1 and found.constant is None:  # all get the same value
            found = Value(self._temporary(found.kind, found.text), found.kind)
        stores = [line for target in targets for line in self._store(writer, target, found)]
        return [*self.before, *stores]

    def _apart(self, targets: list[ast.expr], value: ast.expr) -> list[str]:
        """Set several at once: all values are taken before anything is set."""
        if isinstance(value, ast.Tuple) and len(value.elts) == len(targets):
            writer = self._writer(value)
            found = [writer.value(one) for one in value.elts]
            if not _are_independent(targets, value.elts):
                found = [self._kept(one) for one in found]
        else:
            writer = self._writer(value)
            whole = writer.value(value)
            if not isinstance(whole.kind, Struct) or len(whole.kind.fields) != len(targets):
                raise refused(value, f"does not give {len(targets)} values")
            text = whole.text if isinstance(value, ast.Name) else self._temporary(whole.kind, whole.text)
            found = [Value(f"{text}.v{i}", kind) for i, kind in enumerate(whole.kind.fields)]
        before = self.before
        stores = []
        for target, one in zip(targets, found, strict=True):
            if not self._is_dropped(target, one):
                stores += self._store(self._writer(target), target, one)
        return [*before, *stores]

    def _kept(self, value: Value) -> Value:
        if value.constant is not None:
            return value
        return Value(self._temporary(value.kind, value.text), value.kind)

    def _is_dropped(self, target: ast.expr, value: Value) -> bool:
        """Return whether a part of a tuple is not used; its kind is noted all the same."""
        if isinstance(target, ast.Name) and not self.scopes.is_read(target.id):
            self._note_kind(target, value.kind)
            return True
        return False

    def _store(self, writer: Expressions, target: ast.expr, value: Value) -> list[str]:
        if isinstance(target, (ast.Subscript, ast.Attribute)):
            place = writer.place(target)
            self._note_written(target.value)
            return [f"{place} = {writer.stored(target, value)};"]
        if not isinstance(target, ast.Name):
            raise refused(target, "cannot be set")
        kind = self._note_kind(target, value.kind)
        if not self.scopes.is_read(target.id):
            return [f"(void)({value.text});"]
        if self.scopes.is_declared_in(target.id, self.where):
            is_constant = self.scopes.is_constant(target.id, self.where)
            return [f"{self._declared(kind, target.id, is_constant=is_constant)} = {value.text};"]
        return [f"{local(target.id)} = {value.text};"]

    def _note_kind(self, target: ast.Name, kind: Kind) -> Kind:
        if kind == VOID or kind in ITEM_KIND or isinstance(kind, (Table, Row)):
            raise refused(target, "only numbers, tuples and records get a name")
        known = self.kinds.get(target.id, kind)
        both = common(known, kind)
        if both is None:
            raise refused(target, f"holds two kinds of value, {known.c} and {kind.c}; use two names")
        if target.id in self.arguments and both != known:
            raise refused(target, f"is an argument of kind {known.c} and gets a {kind.c}; use two names")
        self.kinds[target.id] = both
        return both

    def _augmented(self, node: ast.AugAssign) -> list[str]:
        read = next(one.value for one in parsed(ast.unparse(node.target)).body if isinstance(one, ast.Expr))
        value = ast.BinOp(read, node.op, node.value)
        self._note_writes(value)
        writer = self._writer(value)
        found = writer.value(value)
        lines = self._store(writer, node.target, found)
        sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}.get(type(node.op))
        place, _, text = lines[0].partition(" = ")
        if sign and text.startswith(f"{place} {sign} "):  # x = x + ... is easier to read as x += ...
            right = writer.value(node.value) if writer.before is None else None
            if right is not None and right.kind == found.kind:
                return [f"{place} {sign}= {right.text};"]
        return [*self.before, *lines]

    def _if(self, node: ast.If) -> list[str]:
        self._note_writes(node.test)
        test = self._writer(node.test).test(node.test).text
        lines = [*self.before, f"if ({test}) {{", *self._inside(node.body)]
        if not node.orelse:
            return [*lines, "}"]
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
            at, where = self.at, self.where
            chained = self._block(node.orelse)
            self.at, self.where = at, where
            if chained[0].startswith("if ("):
                return [*lines, f"}} else {chained[0]}", *_closed(chained[1:])]
            return [*lines, "} else {", *(INDENT + line for line in chained), "}"]
        return [*lines, "} else {", *self._inside(node.orelse), "}"]

    def _return(self, node: ast.Return) -> list[str]:
        if node.value is None:
            return ["return;"]
        self._note_writes(node.value)
        value = self._writer(node.value).value(node.value)
        both = value.kind if self.result is None else _joined(self.module, self.result, value.kind)
        if both is None or isinstance(both, (Table, Row)) or both == VOID or both in ITEM_KIND:
            raise refused(node, "functions return numbers or tuples, of one kind in all places")
        self.result = both
        text = value.text
        if isinstance(both, Struct) and both != value.kind:
            text = text.replace(f"({value.kind.c})", f"({both.c})", 1)
        return [*self.before, f"return {text};"]

    def _for(self, node: ast.For) -> list[str]:
        if isinstance(node.iter, ast.Call):
            return self._range(node, node.iter)
        if isinstance(node.iter, ast.Tuple):
            return self._listed(node, node.iter)
        return self._over_table(node)

    def _range(self, node: ast.For, call: ast.Call) -> list[str]:
        if not (
            isinstance(call.func, ast.Name) and call.func.id == "range" and isinstance(node.target, ast.Name)
        ):
            raise refused(node.iter, "loops run over range(...) or a constant tuple")
        self._note_writes(*call.args)
        writer = self._writer(*call.args)
        limits = [self._limit(writer, one) for one in call.args]
        first, last = ("0", limits[0]) if len(limits) == 1 else (limits[0], limits[1])
        step = _step(call)
        before = self.before
        name = node.target.id
        self._note_kind(node.target, INT)
        own = self.scopes.is_owned_by(name, node)
        counter = local(name) if own else self._fresh("i")
        sign, move = ("<", f"+= {step}") if step > 0 else (">", f"-= {-step}")
        move = {"+= 1": "++", "-= 1": "--"}.get(move, f" {move}")
        head = f"for (int32_t {counter} = {first}; {counter} {sign} {last}; {counter}{move}) {{"
        body = self._inside(node.body)
        if not own and self.scopes.is_read(name):
            body.insert(0, f"{INDENT}{local(name)} = {counter};")
        return [*before, head, *body, "}"]

    def _limit(self, writer: Expressions, node: ast.expr) -> str:
        """Return a limit of a loop; Python evaluates it once."""
        value = writer.value(node)
        if value.kind not in WHOLES:
            raise refused(node, "is not a whole number")
        free = {one.id for one in nodes_of(node) if isinstance(one, ast.Name)} & set(self.kinds)
        fixed = all(self.scopes.is_fixed(name) for name in free)
        touches = any(isinstance(one, (ast.Call, ast.Subscript)) or is_field(one) for one in nodes_of(node))
        if (fixed and not touches) or value.constant is not None:
            return value.within(LESS)
        return self._temporary(value.kind, value.text)

    def _listed(self, node: ast.For, items: ast.Tuple) -> list[str]:
        """Write a loop over values that are listed: they are put into an array first."""
        writer = self._writer(items)
        values = [writer.number(one) for one in items.elts]
        kind = REAL if any(value.kind == REAL for value in values) else values[0].kind
        array = self._fresh("each")
        text = ", ".join(value.text for value in values)
        before = [*self.before, f"const {self.spelled(kind)} {array}[{len(values)}] = {{{text}}};"]
        return [*before, *self._each(node, (len(values),), kind, array)]

    def _over_table(self, node: ast.For) -> list[str]:
        table = self._writer(node.iter).value(node.iter).kind
        if not isinstance(table, Table):
            raise refused(node.iter, "loops run over range(...) or a constant tuple")
        return self._each(node, table.shape, table.item, table.c)

    def _each(self, node: ast.For, shape: tuple[int, ...], kind: Kind, array: str) -> list[str]:
        index = self._fresh("i")
        parts = _names(node.target)
        columns = [f"[{j}]" for j in range(shape[1])] if len(shape) == 2 else [""]
        if len(parts) != len(columns) or len(shape) > 2:
            raise refused(node.target, f"does not fit to rows of {len(columns)}")
        sets = []
        for part, column in zip(parts, columns, strict=True):
            self._note_kind(part, kind)
            own = f"const {self.spelled(kind)} " if self.scopes.is_owned_by(part.id, node) else ""
            if self.scopes.is_read(part.id):
                sets.append(f"{INDENT}{own}{local(part.id)} = {array}[{index}]{column};")
        head = f"for (int32_t {index} = 0; {index} < {shape[0]}; {index}++) {{"
        return [head, *sets, *self._inside(node.body), "}"]


class Callees(Module):
    """What a function knows of those it calls."""

    def writes(self, name: str) -> bool:
        raise NotImplementedError

    def written(self, name: str) -> tuple[int, ...]:
        raise NotImplementedError


def _joined(module: Module, a: Kind, b: Kind) -> Kind | None:
    """Return the kind that holds both results; tuples element by element."""
    if isinstance(a, Struct) and isinstance(b, Struct) and len(a.fields) == len(b.fields):
        parts = [common(x, y) for x, y in zip(a.fields, b.fields, strict=True)]
        known = [part for part in parts if part is not None]
        return module.struct(tuple(known)) if len(known) == len(parts) else None
    return common(a, b)


def _step(call: ast.Call) -> int:
    if len(call.args) < 3:
        return 1
    try:
        step = ast.literal_eval(call.args[2])
    except ValueError:
        step = 0
    if not isinstance(step, int) or step == 0:
        raise refused(call, "the step of a range is a constant")
    return step


def _names(target: ast.expr) -> list[ast.Name]:
    parts = target.elts if isinstance(target, ast.Tuple) else [target]
    return [part for part in parts if isinstance(part, ast.Name)]


def _reads(node: ast.expr, name: str) -> bool:
    return any(isinstance(one, ast.Name) and one.id == name for one in nodes_of(node))


def _are_independent(targets: list[ast.expr], values: list[ast.expr]) -> bool:
    for i, target in enumerate(targets):
        later = values[i + 1 :]
        if isinstance(target, ast.Name):
            if any(_reads(value, target.id) for value in later):
                return False
        elif any(
            isinstance(one, (ast.Subscript, ast.Call)) or is_field(one)
            for value in later
            for one in nodes_of(value)
        ):
            return False
    return True


def _closed(chained: list[str]) -> list[str]:
    """Return the lines of a chain of `else if` with an `else` at its end (MISRA C 15.7)."""
    branches = [line for line in chained if line.startswith("} else")]
    if branches and not branches[-1].startswith("} else if"):
        return chained
    return [*chained[:-1], "} else {", f"{INDENT}/* as it is */", "}"]
