"""The parameters of a node as a flat table with dotted names, to be read and set from outside."""

import dataclasses
from collections.abc import Iterator
from typing import Any

from vegrip.config import Declaration, declaration, replace
from vegrip.errors import ConfigError, suggestion


def rows(group: Any, prefix: str = "") -> Iterator[tuple[str, Any, Declaration]]:
    """Yield dotted name, value and declaration of every parameter in ``group`` and the groups inside it."""
    if not dataclasses.is_dataclass(group):
        return
    for field in dataclasses.fields(group):
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
    """Return ``group`` with the parameter of the dotted ``name`` set to ``value``.

    Raises:
        ConfigError: no such parameter, wrong type, out of bounds, or not to be changed while ``running``.

    """
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
