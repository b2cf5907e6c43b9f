"""The lifecycle of a managed node, as in ROS 2: which transition leads where. Pure.

::

    unconfigured --configure--> inactive --activate--> active
         ^-------cleanup-----------'  ^---deactivate-----'
    shutdown leads from everywhere to finalized, which nothing leaves.
"""

import dataclasses
from collections.abc import Iterator
from typing import Any

from vegrip.config import Declaration, constants, declaration, replace
from vegrip.errors import ConfigError, UsageError, suggestion
from vegrip.messages import Lifecycle


def rows(group: Any, prefix: str = "") -> Iterator[tuple[str, Any, Declaration]]:
    """Yield dotted name, value and declaration of every parameter in ``group`` and the groups inside it."""
    if not dataclasses.is_dataclass(group):
        return
    fixed = constants(group)
    for field in dataclasses.fields(group):
        if field.name in fixed:
            continue
        value = getattr(group, field.name)
        if dataclasses.is_dataclass(value):
            yield from rows(value, f"{prefix}{field.name}.")
        else:
            yield prefix + field.name, value, declaration(group, field.name)


def describe_parameters(group: Any) -> list[dict[str, Any]]:
    return [
        {"name": name, "value": value, "type": type(value).__name__, **dataclasses.asdict(declared)}
        for name, value, declared in rows(group)
    ]


def with_value(group: Any, name: str, value: Any, running: bool, where: str) -> Any:
    """Return ``group`` with the parameter of the dotted ``name`` set to ``value``."""
    known = {known: declared for known, _, declared in rows(group)}
    if name not in known:
        raise ConfigError(f"{where}: there is no parameter {name!r}; {suggestion(name, known)}")
    if running and not known[name].live:
        raise ConfigError(
            f"{where}: {name!r} cannot be changed now; set the node unconfigured first (vegrip lifecycle set)"
        )
    return _with(group, name.split("."), value, where)


def _with(group: Any, path: list[str], value: Any, where: str) -> Any:
    head, *rest = path
    if not rest:
        return replace(group, head, value, where)
    return dataclasses.replace(group, **{head: _with(getattr(group, head), rest, value, f"{where}.{head}")})


TRANSITIONS: dict[str, tuple[frozenset[Lifecycle], Lifecycle]] = {
    # name: (states it may leave, state it leads to)
    "configure": (frozenset({Lifecycle.UNCONFIGURED}), Lifecycle.INACTIVE),
    "activate": (frozenset({Lifecycle.INACTIVE}), Lifecycle.ACTIVE),
    "deactivate": (frozenset({Lifecycle.ACTIVE}), Lifecycle.INACTIVE),
    "cleanup": (frozenset({Lifecycle.INACTIVE}), Lifecycle.UNCONFIGURED),
    "shutdown": (frozenset(Lifecycle) - {Lifecycle.FINALIZED}, Lifecycle.FINALIZED),
}


def state_after(state: Lifecycle, transition: str) -> Lifecycle:
    """Return the state that ``transition`` leads to from ``state``."""
    if transition not in TRANSITIONS:
        raise UsageError(f"there is no transition {transition!r}; there are {', '.join(TRANSITIONS)}")
    sources, target = TRANSITIONS[transition]
    if state not in sources:
        possible = ", ".join(allowed_transitions(state)) or "none"
        raise UsageError(f"a node that is {state.name.lower()} cannot {transition}; it can: {possible}")
    return target


def allowed_transitions(state: Lifecycle) -> list[str]:
    return [name for name, (sources, _) in TRANSITIONS.items() if state in sources]


def route(state: Lifecycle, target: Lifecycle) -> list[str]:
    routes: dict[Lifecycle, list[str]] = {state: []}
    frontier = [state]
    while target not in routes and frontier:
        here = frontier.pop(0)
        for name in allowed_transitions(here):
            there = TRANSITIONS[name][1]
            if there not in routes:
                routes[there] = [*routes[here], name]
                frontier.append(there)
    if target not in routes:
        raise UsageError(f"a node that is {state.name.lower()} cannot become {target.name.lower()}")
    return routes[target]
