"""Configuration: typed, bounded parameters with units, built from TOML, refused in one clear sentence.

A group of parameters is a frozen dataclass whose fields are declared with :func:`parameter`. The same
declaration serves the configuration file, the help text and ``vegrip param`` on a running node.

>>> @dataclass(frozen=True)
... class Grip:
...     wanted_margin: float = parameter(0.3, unit="1", low=0.05, high=0.9, doc="slip margin to keep")
>>> build(Grip, {"wanted_margin": 0.4}, "hand.toml [grip]").wanted_margin
0.4
"""

import dataclasses
import datetime
import functools
import json
import math
import numbers
import re
import tomllib
import typing
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import Any, TypeVar

from vegrip.errors import ConfigError, suggestion
from vegrip.whole_file import reading

T = TypeVar("T")
TYPES: dict[type[Any], str] = {
    int: "a whole number",
    float: "a float",
    str: "text",
    bool: "true or false",
    tuple: "a list",
    dict: "a table",
}

LARGEST_WHOLE = 1000
"""Bits of a whole number in a file; TOML promises 64, and 1024 are beyond every float."""

LONGEST_TOML = 1_000_000
"""Characters of a TOML file; the largest of ours have some thousands."""

DEEPEST_KEY = 16
"""Parts of a dotted key: the parser takes time and memory with the square of their number."""

STRING_OR_COMMENT = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\Z)|'
    r"'''.*?(?:'''|\Z)|"
    r'"(?:[^"\\\n]|\\.)*"?|'
    r"'[^'\n]*'?|#[^\n]*",
    re.DOTALL,
)
DEEP_KEY = re.compile(rf"(?<![\w-])[\w-]++(?:[ \t]*+\.[ \t]*+[\w-]++){{{DEEPEST_KEY}}}")


@dataclass(frozen=True, slots=True)
class Declaration:
    """What is declared of one parameter besides its type and default."""

    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    doc: str = ""
    live: bool = True  # may be changed while the node runs
    choices: tuple[str, ...] = ()


def parameter(
    default: Any = MISSING,
    *,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    doc: str = "",
    live: bool = True,
    choices: tuple[str, ...] = (),
) -> Any:
    """Declare a dataclass field as a parameter; without ``default`` the key is required."""
    declared = {"parameter": Declaration(unit, low, high, doc, live, choices)}
    if isinstance(default, (list, dict, set)):
        return dataclasses.field(default_factory=lambda: type(default)(default), metadata=declared)
    return dataclasses.field(default=default, metadata=declared)


fixed_parameter = functools.partial(parameter, live=False)
"""Declare one that stays as it is while the node runs."""


def constant(
    default: Any,
    *,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    doc: str = "",
    choices: tuple[str, ...] = (),
) -> Any:
    """Declare a field that is no parameter: neither a file nor a running node sets it, only Python does."""
    declared = Declaration(unit, low, high, doc, live=False, choices=choices)
    return dataclasses.field(default=default, metadata={"constant": declared})


def constants(group: type[Any] | Any) -> frozenset[str]:
    """Return the names of what is a constant in a group of parameters."""
    return frozenset(field.name for field in dataclasses.fields(group) if "constant" in field.metadata)


def declaration(cls: type[Any] | Any, name: str) -> Declaration:
    """Return what is declared of the parameter ``name`` of ``cls``."""
    declared = _declarations(cls if isinstance(cls, type) else type(cls)).get(name)
    if declared is None:
        raise ConfigError(f"there is no parameter {name!r}; {suggestion(name, _names(cls))}")
    return declared


@functools.cache
def _declarations(cls: type[Any]) -> dict[str, Declaration]:
    return {
        field.name: field.metadata.get("parameter") or field.metadata.get("constant", Declaration())
        for field in dataclasses.fields(cls)
    }


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file; a missing or broken one raises :class:`ConfigError` with the line."""
    try:
        with reading(path, ConfigError), path.open(encoding="utf-8") as file:
            text = file.read(LONGEST_TOML + 1)
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is not a text file in UTF-8; give a file of TOML") from None
    try:
        return parse_toml(text)
    except (ValueError, RecursionError) as error:  # also a number of 5000 digits, or a thousand brackets
        raise ConfigError(f"{path}: is not valid TOML: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the table in ``text``.

    Raises:
        ValueError: not TOML, too long, a key of too many parts, or a whole number that no float comes near.
        RecursionError: brackets in thousands of brackets.

    """
    if len(text) > LONGEST_TOML:
        raise ValueError(f"it has more than {LONGEST_TOML} characters")
    bare = STRING_OR_COMMENT.sub(lambda found: "" if found[0][0] == "#" else "_", text)
    if deep := DEEP_KEY.search(bare):
        raise ValueError(f"the key {deep[0][:20]}... has more than {DEEPEST_KEY} parts")
    table = tomllib.loads(text)
    _check_whole(table)
    return table


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return both tables; where both have a key ``over`` holds, and of two tables the keys of both."""
    inner = {
        key: merged(base[key], value)
        for key, value in over.items()
        if isinstance(value, Mapping) and isinstance(base.get(key), Mapping)
    }
    return {**base, **over, **inner}


def _check_whole(value: Any) -> None:
    if isinstance(value, Mapping):
        value = value.values()
    elif not isinstance(value, list):
        if isinstance(value, int) and value.bit_length() > LARGEST_WHOLE:
            raise ValueError("a whole number has more than 300 digits")
        return
    for one in value:
        _check_whole(one)


def build(cls: type[T], table: Mapping[str, Any], where: str) -> T:
    """Make a ``cls`` from ``table``; ``where`` names the file and section in complaints.

    Raises:
        ConfigError: unknown or missing key, wrong type, value out of bounds.

    """
    fixed = constants(cls)
    fields = {f.name: f for f in dataclasses.fields(cls) if f.name not in fixed}  # type: ignore[arg-type]
    for key in table:
        if key in fixed:
            raise ConfigError(f"{where}: {key!r} is a constant and no parameter; leave it out")
        if key not in fields:
            raise ConfigError(f"{where}: unknown key {key!r}; {suggestion(key, fields, 'known are')}")
    for name, field in fields.items():
        if name not in table and field.default is MISSING and field.default_factory is MISSING:
            raise ConfigError(f"{where}: the key {name!r} is missing{_hint(cls, name)}")
    hints = _hints(cls)
    values = {key: _checked(cls, key, value, hints[key], where) for key, value in table.items()}
    return cls(**values)


def replace(group: T, name: str, value: Any, where: str = "parameter") -> T:
    """Return ``group`` with the parameter ``name`` set to ``value``, checked as in :func:`build`."""
    declaration(group, name)
    hint = _hints(type(group))[name]
    checked = _checked(type(group), name, value, hint, where)
    replaced: T = dataclasses.replace(group, **{name: checked})  # type: ignore[type-var]
    return replaced


def check(group: Any, where: str, known: Any = None) -> None:
    """Refuse a ``group`` that was made in Python where a value is not as it is declared, or of another kind.

    Groups inside it are looked at, too; what ``known`` has also, which was looked at before, is not.

    Raises:
        ConfigError: wrong type, value out of bounds.

    """
    for name, hint in _hints(type(group)).items():
        value, before = getattr(group, name), getattr(known, name, None)
        if value is before and value is not None:
            continue
        if not dataclasses.is_dataclass(hint):
            _checked(type(group), name, _plain(value), hint, where)
        elif not isinstance(value, typing.cast("type[Any]", hint)):
            kind = getattr(hint, "__name__", hint)
            raise ConfigError(f"{where}: {name!r} is {value!r}; it must be a {kind}")
        else:
            check(value, f"{where}.{name}", before)


def _hints(cls: Any) -> dict[str, Any]:
    return _kept_hints(cls)


_kept_hints = functools.cache(typing.get_type_hints)


def _plain(value: Any) -> Any:
    """Return a number of whatever library as one of Python."""
    if isinstance(value, (bool, int, float)):
        return value
    if isinstance(value, numbers.Integral):
        return int(value)
    return float(value) if isinstance(value, numbers.Real) else value


def _checked(cls: type[Any], name: str, value: Any, hint: Any, where: str) -> Any:
    if dataclasses.is_dataclass(hint) and isinstance(value, Mapping):
        return build(typing.cast("type[Any]", hint), value, f"{where}.{name}")
    declared = declaration(cls, name)
    value = _typed(value, hint, f"{where}: {name!r}", declared.unit)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        _check_bounds(value, declared, f"{where}: {name!r}")
    if declared.choices and value not in declared.choices:
        raise ConfigError(f"{where}: {name!r} is {value!r}; it must be one of {', '.join(declared.choices)}")
    return value


def _typed(value: Any, hint: Any, what: str, unit: str) -> Any:
    wanted = typing.get_origin(hint) or hint
    if wanted is float and isinstance(value, int) and not isinstance(value, bool):
        return as_float(value, what)
    if wanted is tuple and isinstance(value, (list, tuple)):
        return _elements(value, (*typing.get_args(hint), Any)[0], what, unit)
    if wanted is dict and isinstance(value, Mapping):
        _elements(value.values(), (*typing.get_args(hint), Any, Any)[1], what, unit)
    if (
        wanted is Any
        or not isinstance(wanted, type)
        or (isinstance(value, wanted) and (wanted is bool) == isinstance(value, bool))
    ):
        return value
    of = f" in {unit}" if unit and unit != "1" else ""
    kind = "a table" if dataclasses.is_dataclass(wanted) else TYPES.get(wanted, wanted.__name__)
    raise ConfigError(f"{what} is {value!r}; it must be {kind}{of}")


def _elements(values: Iterable[Any], of: Any, what: str, unit: str) -> tuple[Any, ...]:
    if of is Any:
        return tuple(values)
    return tuple(_typed(value, of, f"{what}, number {i},", unit) for i, value in enumerate(values, 1))


def as_float(value: float, what: str) -> float:
    """Return ``value`` as a float.

    Raises:
        ConfigError: a whole number beyond all floats.

    """
    try:
        return float(value)
    except OverflowError:
        raise ConfigError(f"{what} is a number of more than 300 digits") from None


def _check_bounds(value: float, declared: Declaration, what: str) -> None:
    if not declared.low <= value <= declared.high:  # NaN fails too
        value = as_float(value, what)
        bounds = (
            f"{declared.low:g} .. {declared.high:g} {'' if declared.unit == '1' else declared.unit}".rstrip()
        )
        raise ConfigError(f"{what} is {value:g}; it must lie in {bounds}")


def _hint(cls: type[Any], name: str) -> str:
    declared = declaration(cls, name)
    text = ", ".join(part for part in (declared.doc, declared.unit and f"in {declared.unit}") if part)
    return f" ({text})" if text else ""


def _names(cls: type[Any] | Any) -> list[str]:
    return [field.name for field in dataclasses.fields(cls) if field.name not in constants(cls)]


BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_key(name: str) -> str:
    """Return ``name`` as a key: bare where TOML allows that, else quoted."""
    return name if BARE_KEY.fullmatch(name) else toml_value(name)


def toml_value(value: Any) -> str:
    """Return ``value`` as TOML on one line: text, number, truth, date, or a list or table of them.

    >>> toml_value({"kind": "crc8", "polynomial": 47, "data_id": [1]})
    '{ kind = "crc8", polynomial = 47, data_id = [1] }'

    Raises:
        TypeError: TOML has no such value.

    """
    match value:
        case str():
            # JSON's strings are TOML's, but for DEL, which TOML wants escaped
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        case bool():
            return "true" if value else "false"
        case int() | float():  # the shortest text that reads back as the same number
            return repr(float(value)) if isinstance(value, float) else repr(int(value))
        case datetime.date() | datetime.time():
            return value.isoformat()
        case Mapping():
            inner = ", ".join(f"{toml_key(key)} = {toml_value(each)}" for key, each in value.items())
            return f"{{ {inner} }}" if inner else "{}"
        case list() | tuple():
            return "[" + ", ".join(map(toml_value, value)) + "]"
    raise TypeError(f"TOML has no {type(value).__name__}: {value!r}")
