"""From an ordered list of effects to an ordered list of calls, checked.

Nothing here runs physics. The rules, each with its complaint:

* every hook stands at a stage that exists, and what it takes exists there;
* a quantity has one definition, before its modifications;
* nothing is changed after another effect has used it;
* symbols and states have one owner.

A composed model is then tried on a few contacts, hook by hook, so that an effect that fails is named.
"""

import ast
import builtins
import inspect
import keyword
import math
import textwrap
import types
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from vegrip.effects.contract import (
    FACTORS,
    GEOMETRY,
    INPUTS,
    READING,
    STAGES,
    STARTS,
    Effect,
    Hook,
)
from vegrip.errors import ModelError
from vegrip.python_text import parsed
from vegrip.types import Floats

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
        names = _foreign_names(effect, text)
        renamed = tuple((local, self._needed(effect, local, scope)) for local in names)
        self.parts[name] = _renamed(effect, text, name, renamed)

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


# A diagnosis composes a hundred models of the same hooks.


@lru_cache(maxsize=1024)
def _renamed(effect: str, text: str, name: str, renamed: tuple[tuple[str, str], ...]) -> str:
    return ast.unparse(_Rename(dict(renamed), name).visit(_function(effect, text)))


@lru_cache(maxsize=1024)
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


@lru_cache(maxsize=1024)
def _foreign_names(effect: str, text: str) -> tuple[str, ...]:
    tree = _function(effect, text)
    bound = {argument.arg for argument in tree.args.args}
    used: dict[str, None] = {}
    for statement in tree.body:
        for node in ast.walk(statement):
            if isinstance(node, ast.Name):
                if isinstance(node.ctx, ast.Store):
                    bound.add(node.id)
                else:
                    used[node.id] = None
    return tuple(name for name in used if name not in bound)


DERIVED = ("stiffness", "elastic_exponent")
"""d N_e / d x [N/m] and d ln N_e / d ln x [-] at the present depth, made only where a hook asks."""


@dataclass(frozen=True, slots=True)
class Call:
    """One hook in the generated step: ``gives, *states = function(*takes)``."""

    effect: str
    stage: str
    function: str
    takes: tuple[str, ...]
    gives: str  # "" = only states
    states: tuple[str, ...]

    @property
    def results(self) -> tuple[str, ...]:
        return (self.gives, *self.states) if self.gives else self.states


@dataclass(frozen=True, slots=True)
class Plan:
    """A composed model: calls by stage, and the texts of their functions."""

    calls: dict[str, tuple[Call, ...]]
    texts: dict[str, str]
    parameters: tuple[str, ...]
    states: tuple[str, ...]

    def uses(self, stage: str, name: str) -> bool:
        return any(name in call.takes for call in self.calls[stage])


def compose(effects: Sequence[Effect]) -> Plan:
    """Order and check the hooks of ``effects``.

    Raises:
        ModelError: names the effect and the remedy.

    """
    parameters = _unique((e.name, p.symbol) for e in effects for p in e.parameters)
    states = _unique((e.name, s.name) for e in effects for s in e.states)
    _check_names(effects, {**parameters, **states})
    texts = Texts()
    calls = {stage: tuple(_calls(stage, effects, texts)) for stage in STAGES}
    plan = Plan(calls, texts.parts, tuple(parameters), tuple(states))
    _check_quantities(plan)
    _check_definitions(plan)
    return plan


def share_a_name(one: Effect, other: Effect) -> bool:
    """Return whether a parameter or a state of both has the same name, so that no model can have both."""
    parameters = {p.symbol for p in one.parameters} & {p.symbol for p in other.parameters}
    return bool(parameters or {s.name for s in one.states} & {s.name for s in other.states})


def _calls(stage: str, effects: Sequence[Effect], texts: Texts) -> Iterator[Call]:
    """Yield the calls of a stage: what defines its quantity, what else gives something, what remembers.

    An effect stands at one place in the list but may act at several stages; where it modifies a quantity
    (the friction on an incline) that a later effect defines, the definition goes first.
    """
    found = [(e, i, h) for e in effects for i, h in enumerate(e.hooks) if h.stage == stage]
    for effect, index, hook in sorted(found, key=lambda item: _rank(item[2])):
        takes = tuple(inspect.signature(hook.function).parameters)
        states = tuple(s.name for s in effect.states if s.name in takes) if stage not in READING else ()
        yield Call(effect.name, stage, texts.add_hook(effect.name, index, hook), takes, hook.gives, states)


def _rank(hook: Hook) -> int:
    quantity = STAGES[hook.stage]
    defines = hook.gives == quantity and quantity not in STARTS
    if defines and quantity not in inspect.signature(hook.function).parameters:
        return 0
    return 1 if hook.gives else 2


def _unique(owned: Iterator[tuple[str, str]]) -> dict[str, str]:
    owners: dict[str, str] = {}
    for effect, name in owned:
        if name in owners:
            raise ModelError(
                f"the effects {owners[name]} and {effect} both have {name!r}; rename one, or leave one out"
            )
        owners[name] = effect
    return owners


def _check_names(effects: Sequence[Effect], owners: dict[str, str]) -> None:
    taken = {*INPUTS, *GEOMETRY, *FACTORS, *STAGES.values(), *DERIVED, "dt", "elastic_before"}
    for name, effect in owners.items():
        if not name.isidentifier() or keyword.iskeyword(name) or name.endswith("_") or name in taken:
            raise ModelError(
                f"the effect {effect} calls something {name!r}, which is taken; choose another name"
            )
    seen: set[str] = set()
    for one in effects:
        if one.name in seen:
            raise ModelError(f"the effect {one.name} is there twice; leave one out")
        seen.add(one.name)
        for hook in one.hooks:
            _check_hook(one, hook, owners)


def _check_hook(effect: Effect, hook: Hook, owners: dict[str, str]) -> None:
    if hook.stage not in STAGES:
        raise ModelError(
            f"the effect {effect.name} has a hook at {hook.stage!r}; the stages are {', '.join(STAGES)}"
        )
    known = {*STAGES.values(), *FACTORS, *INPUTS, *owners, ""}
    if hook.gives not in known:
        raise ModelError(
            f"the effect {effect.name} gives {hook.gives!r}, which nothing uses; give {STAGES[hook.stage]!r}"
        )
    if hook.gives == "compliance" and hook.stage != "tip":
        raise ModelError(f"the effect {effect.name} gives compliance at {hook.stage!r}; give it at 'tip'")
    if hook.gives == "" and hook.stage in READING:
        raise ModelError(
            f"the effect {effect.name} remembers at {hook.stage!r}, where states are only read; use 'force'"
        )


def _check_quantities(plan: Plan) -> None:
    exists = {*INPUTS, *GEOMETRY, *FACTORS, *plan.parameters, *plan.states, "dt"}
    for stage, quantity in STAGES.items():
        exists |= {quantity} if quantity in STARTS else set()
        if stage == "force":
            exists |= {"elastic_before", *DERIVED}
        if stage == "area":
            exists -= {"dt", "elastic_before"}
        for call in plan.calls[stage]:
            for name in call.takes:
                if name not in exists:
                    raise ModelError(_missing(call, name, exists))
            exists |= set(call.results)


def _missing(call: Call, name: str, exists: set[str]) -> str:
    if name in STAGES.values():
        return (
            f"the effect {call.effect} uses {name} at the stage {call.stage}, where it is not known yet; "
            f"put it after the effect that defines {name}, or move its hook to a later stage"
        )
    return (
        f"the effect {call.effect} uses {name!r}, which does not exist at the stage {call.stage}; "
        f"add the effect that has it, or use one of {', '.join(sorted(exists))}"
    )


def _check_definitions(plan: Plan) -> None:
    """One definition per quantity, first; no change after another effect has used the value."""
    defined: dict[str, str] = {}
    used: dict[str, str] = {}
    for stage, quantity in STAGES.items():
        for call in plan.calls[stage]:
            gives = call.gives
            if gives and gives not in call.takes and gives in defined:
                raise ModelError(
                    f"the effects {defined[gives]} and {call.effect} both define {gives}; leave one out"
                )
            if gives and gives in used and used[gives] != call.effect:
                raise ModelError(
                    f"the effect {call.effect} changes {gives} after {used[gives]} has used it; "
                    f"put {call.effect} before {used[gives]}"
                )
            if gives:
                defined.setdefault(gives, call.effect)
            used |= {name: call.effect for name in call.takes if name != gives and name not in call.states}
        if quantity not in STARTS and quantity not in defined:
            raise ModelError(f"no effect defines {quantity}; add one with a hook at the stage {stage}")


PROBED_DEPTHS = (-0.5, 0.0, 1e-6, 0.3, 1.0, 2.0)  # in reference depths
PROBED_STEPS_S = (0.0, 1e-3, 1.0)  # [s]


def probe(
    effects: Sequence[Effect],
    plan: Plan,
    values: Floats,
    reference_depth: float,
) -> None:
    """Run every hook once at each depth and step."""
    functions = _functions(plan)
    constants = dict(zip([*plan.parameters, *GEOMETRY], map(float, values), strict=True))
    states = {s.name: s.initial for e in effects for s in e.states}
    for depth in PROBED_DEPTHS:
        for dt in PROBED_STEPS_S:
            scope: dict[str, float] = {**constants, **states, **FACTORS, "dt": dt}
            scope |= {"delta": depth * reference_depth, "speed": 0.1 * reference_depth, "elastic_before": 0.0}
            scope |= {"temperature": constants["reference_temperature"] + 1.0, "slip_speed": 0.0}
            scope |= {"tangential_force": 0.0, "tangential_force_x": 0.0, "tangential_force_y": 0.0}
            scope |= {"torque": 0.0, "stiffness": 1.0, "elastic_exponent": 1.5}
            _walk(plan, functions, scope)
            states = {name: scope[name] for name in states}


def _functions(plan: Plan) -> dict[str, Any]:
    scope: dict[str, Any] = {"math": math}
    for text in plan.texts.values():
        exec(_code(text), scope)  # noqa: S102 - the user's own model, as on import
    return scope


@lru_cache(maxsize=512)
def _code(text: str) -> types.CodeType:
    return compile(text, "<effect>", "exec")


def _walk(plan: Plan, functions: dict[str, Any], scope: dict[str, float]) -> None:
    for stage, quantity in STAGES.items():
        if quantity in STARTS:
            scope[quantity] = scope[STARTS[quantity]]
        for call in plan.calls[stage]:
            scope |= _checked(call, functions[call.function], scope)
        scope["force"] = max(scope.get("force", 0.0), 0.0)


def _checked(call: Call, function: Any, scope: dict[str, float]) -> dict[str, float]:
    arguments = {name: scope[name] for name in call.takes}
    at = ", ".join(f"{name} = {value:g}" for name, value in arguments.items())
    try:
        answer = function(**arguments)
    except Exception as error:
        raise ModelError(
            f"the effect {call.effect} fails at {call.stage} ({error}) with {at}; guard it"
        ) from error
    given = answer if isinstance(answer, tuple) else (answer,)
    if len(given) != len(call.results):
        raise ModelError(
            f"the effect {call.effect} returns {len(given)} values at {call.stage}; "
            f"it must return {', '.join(call.results)}"
        )
    for name, value in zip(call.results, given, strict=True):
        if not math.isfinite(value):
            raise ModelError(
                f"the effect {call.effect} gives {name} = {value} at {call.stage} with {at}; guard it"
            )
    return dict(zip(call.results, given, strict=True))
