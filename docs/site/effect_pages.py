"""The catalogue of effects, written from the effects: equation, parameters, motion that shows each."""

import importlib
import re
from collections.abc import Iterator

from vegrip.effects import BUILT_IN
from vegrip.effects.contract import Effect
from vegrip.parameters import Parameter

ROLE = re.compile(r":\w+:`~?(?:[\w.]*\.)?(\w+)(?: <[^>]*>)?`")  # :mod:`adhesion <vegrip.effects.adhesion>`
HEAD = """# Catalogue of effects

In the order in which they act. Priors of positive parameters are of their logarithm, in percent. What the
columns mean, and which effects look alike: [physical effects](../effects.md).
"""


def page() -> str:
    """Return the page as Markdown."""
    return "\n".join([HEAD, *(line for name in BUILT_IN for line in described(name))])


def described(name: str) -> Iterator[str]:
    """Yield the lines of one effect: its docstring, parameters, rivals and motion."""
    module = importlib.import_module(f"vegrip.effects.{name}")
    effect: Effect = module.EFFECT
    yield f"## {name}\n"
    yield f"{_prose(module.__doc__ or effect.summary)}\n"
    if effect.parameters:
        yield "| parameter | unit | typical | prior | bounds | absent at | meaning |"
        yield "|---|---|---|---|---|---|---|"
        yield from (_row(parameter) for parameter in effect.parameters)
        yield ""
    yield f"Shows in: {', '.join(effect.channels)}."
    if effect.residual:
        yield f"What a model without it leaves: {effect.residual}."
    if effect.confounded:
        yield f"Resembles {', '.join(f'[{one}](#{one})' for one in effect.confounded)}."
    if effect.experiment:
        yield f"Separated by: {effect.experiment}."
    yield ""


def _row(p: Parameter) -> str:
    prior = f"{100.0 * p.std:g} %" if p.transform == "log" else f"{p.std:g}"
    absent = "-" if p.null is None else f"{p.null:g}"
    bounds = f"{p.low:g} .. {p.high:g}"
    return f"| `{p.symbol}` | {p.unit} | {p.default:g} | {prior} | {bounds} | {absent} | {p.doc} |"


def _prose(text: str) -> str:
    return ROLE.sub(r"`\1`", text.strip()).replace("``", "`")
