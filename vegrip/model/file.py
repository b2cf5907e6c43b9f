"""Model files: TOML that people can read and change; it round-trips exactly."""

import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from vegrip.config import parse_toml, read_toml, toml_value
from vegrip.effects import Effect, effect
from vegrip.effects.file import read_effect
from vegrip.errors import ConfigError, suggestion
from vegrip.model.model import ContactModel, Shown
from vegrip.parameters import Value, declared
from vegrip.whole_file import write_whole

FINGERTIP = ("tip_radius", "reference_depth", "reference_temperature")
FIELDS = ("value", "std", "low", "high", "learn")


def write_model(model: ContactModel, path: Path | str) -> None:
    """Write ``model``; :func:`read_model` gives the same back, to the last bit."""
    write_whole(Path(path), model_text(model))


def model_text(model: ContactModel) -> str:
    """Return the text of the model file of ``model``."""
    lines = [
        "# A vegrip contact model. SI units; std is that of the logarithm where a parameter is scaled so.",
        "",
    ]
    lines += ["[fingertip]", *(f"{name} = {toml_value(getattr(model, name))}" for name in FINGERTIP), ""]
    for one in model.effects:
        lines += ["[[effects]]", f"# {one.summary}", f"name = {toml_value(one.name)}"]
        lines += [f"file = {toml_value(one.file)}"] * bool(one.file)
        for parameter in one.parameters:
            value = model.values[parameter.symbol]
            fields = ", ".join(f"{name} = {toml_value(getattr(value, name))}" for name in FIELDS)
            lines.append(f"{parameter.symbol} = {{ {fields} }}  # [{parameter.unit}] {parameter.doc}")
        lines.append("")
    shown = {name: at for name, at in asdict(model.shown).items() if math.isfinite(at)}
    if shown:
        lines += ["[shown]  # in m, m/s, N, degC: beyond it nothing was seen of what the model says"]
        lines += [*(f"{name} = {toml_value(at)}" for name, at in shown.items()), ""]
    lines += [
        "[provenance]",
        *(f"{toml_value(key)} = {toml_value(text)}" for key, text in model.provenance.items()),
    ]
    return "\n".join(lines) + "\n"


def read_model(path: Path | str) -> ContactModel:
    """Read a model file; a parameter that is left out keeps the default of its effect.

    Raises:
        ConfigError: not readable, or a key that does not belong there; names file and key.
        ModelError: the model cannot be built; names the effect and the remedy.

    """
    return _built(read_toml(Path(path)), str(path))


def parse_model(text: str) -> ContactModel:
    """Return the model whose file has this ``text``: the inverse of :func:`model_text`."""
    try:
        return _built(parse_toml(text), "the model")
    except ValueError as error:
        raise ConfigError(f"the model is not valid TOML: {error}") from None


def _built(table: Mapping[str, Any], path: str) -> ContactModel:
    _known(table, ("fingertip", "effects", "shown", "provenance"), f"{path}")
    fingertip = table.get("fingertip", {})
    _known(fingertip, FINGERTIP, f"{path} [fingertip]")
    if "tip_radius" not in fingertip:
        raise ConfigError(f"{path} [fingertip]: the key 'tip_radius' is missing (in m)")
    radius = _number(fingertip["tip_radius"], f"{path} [fingertip]: 'tip_radius'")
    rest = {"reference_depth": radius / 10.0, "reference_temperature": 23.0}
    rest |= {key: _number(fingertip[key], f"{path} [fingertip]: {key!r}") for key in rest if key in fingertip}
    effects, values = [], {}
    for section in table.get("effects", []):
        if "name" not in section:
            raise ConfigError(f"{path} [[effects]]: the key 'name' is missing")
        one = _effect(section, path)
        where = f"{path} effect {one.name}"
        _known(section, ("name", *["file"] * bool(one.file), *(p.symbol for p in one.parameters)), where)
        effects.append(one)
        for p in one.parameters:
            values[p.symbol] = _value(declared(p), section.get(p.symbol, {}), f"{where}: {p.symbol!r}")
    provenance = {key: str(text) for key, text in table.get("provenance", {}).items()}
    shown = _shown(table.get("shown", {}), f"{path} [shown]")
    return ContactModel(tuple(effects), values, radius, **rest, provenance=provenance, shown=shown)


def _shown(table: Mapping[str, Any], where: str) -> Shown:
    _known(table, tuple(one.name for one in fields(Shown)), where)
    return Shown(**{key: _number(value, f"{where}: {key!r}") for key, value in table.items()})


def _effect(section: Mapping[str, Any], path: str) -> Effect:
    """Return the effect of a section: a known one, or that in its ``file``, which lies beside the model."""
    if "file" not in section:
        return effect(section["name"])
    found = read_effect(Path(path).parent / str(section["file"]))
    if found.name != section["name"]:
        raise ConfigError(f"{path} effect {section['name']}: {section['file']} holds the effect {found.name}")
    return found


def _value(default: Value, table: Any, where: str) -> Value:
    if not isinstance(table, Mapping):
        table = {"value": table}
    _known(table, FIELDS, where)
    fields: dict[str, Any] = {name: getattr(default, name) for name in FIELDS}
    for name, given in table.items():
        if name == "learn" and not isinstance(given, bool):
            raise ConfigError(f"{where}: 'learn' is {given!r}; it must be true or false")
        fields[name] = given if name == "learn" else _number(given, f"{where}: {name!r}")
    return Value(**fields)


def _known(table: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in keys:
            raise ConfigError(f"{where}: unknown key {key!r}; {suggestion(key, keys, 'known are')}")


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ConfigError(f"{where} is {value!r}; it must be a number")
    return float(value)
