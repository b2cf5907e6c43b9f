"""The text of drafted laws: the file of one law, and the probe that holds all laws of a place."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from string import Template
from types import MappingProxyType

from vegrip.effects.contract import Effect
from vegrip.effects.file import effect_of
from vegrip.identification.draft.grammar import LAW_SHAPES, LAW_VARIABLES, Law, Place, Variable
from vegrip.parameters import Parameter

ARGUMENT = re.compile(r"\b(?:[a-z]\w*|K)\b")
NOT_ARGUMENTS = {"not", "abs", "max", "min", "math", "exp", "tanh", "floor", "if", "else", "and", "or"}
HEAD = """\
import math

from vegrip.effects import Effect, State, hook
from vegrip.parameters import Parameter
"""
FILE = Template('''\
"""Draft: ``$equation``.

$words.

$found

A draft is a shape that fits, not physics: its author is still to be found.
"""

$head
$constants

$function

EFFECT = Effect(
    name="$name",
    summary="draft: $equation",
    cites=("draft",),
    parameters=($parameters
    ),
    states=($states
    ),
    hooks=(hook(law, stage="$stage", gives="$gives"),),
    experiment="$refute",
)
''')


def function_text(
    place: Place, lines: Sequence[str], change: str, states: Sequence[str], doc: str = ""
) -> str:
    """Return the hook of a law: its ``lines``, then what it gives; what they use are its arguments."""
    results = [place.text.format(f="f", c=change), *states]
    texts = [*lines, *results]
    made = {line.split(" = ")[0].strip() for line in lines if " = " in line} - set(states)
    used = {one for line in texts for one in ARGUMENT.findall(line)} - NOT_ARGUMENTS - made - {place.gives}
    takes = "".join(f"\n    {name}: float," for name in [place.gives, *sorted(used)])
    gives = f"tuple[{', '.join(['float'] * len(results))}]" if states else "float"
    body = [f'"""{doc}"""'] * bool(doc) + [*lines, f"return {', '.join(results)}"]
    return f"def law({takes}\n) -> {gives}:\n" + "".join(f"    {line}\n" for line in body)


def state_text(name: str, variable: Variable) -> str:
    lasting = ", lasting=True" * variable.is_lasting
    return f'State("{name}", "{variable.state_unit}", "{variable.words}"{lasting}),'


def parameters_of(law: Law, name: str, values: Mapping[str, float] = MappingProxyType({})) -> list[Parameter]:
    """Return what a law leaves to a fit: amount ``c``, and where it has them shape ``s`` and time ``tau``.

    ``values``: by those letters, what they begin with.
    """
    at = {"c": 0.2, "s": law.shape.middle, "tau": 1.0} | {
        key: float(f"{one:.6g}") for key, one in values.items()
    }
    amount = Parameter(f"c_{name}", "1", at["c"], 0.3, -20.0, 20.0, "change at SIZE", null=0.0)
    s, tau = f"s_{name}", f"tau_{name}"
    bounds = (law.shape.low, law.shape.high)
    shape = [Parameter(s, "1", at["s"], 0.7, *bounds, "shapes the change", "log")] * bool(law.shape.trials)
    doc = "time constant of the memory"
    memory = [Parameter(tau, "s", at["tau"], 1.5, 1e-3, 1e4, doc, "log")] * law.variable.has_rate
    return [amount, *shape, *memory]


def parameter_text(one: Parameter) -> str:
    numbers = ", ".join(f"{each:.6g}" for each in (one.default, one.std, one.low, one.high))
    kind = f", null={one.null!r}" if one.null is not None else f', transform="{one.transform}"'
    return f'Parameter("{one.symbol}", "{one.unit}", {numbers}, "{one.doc}"{kind}),'


def law_text(
    law: Law, name: str, found: Mapping[str, str], values: Mapping[str, float] = MappingProxyType({})
) -> str:
    """Return the file of a law, an effect called ``name``; ``found`` says where and with what evidence.

    ``values``: of :func:`parameters_of`.
    """
    c, s, tau = f"c_{name}", f"s_{name}", f"tau_{name}"
    parts = [("q", "SIZE", f"z_{name}", law.variable, law.size)]
    if law.second is not None:
        parts.append(("r", "SECOND_SIZE", f"z2_{name}", law.second, law.second_size))
    lines = []
    for letter, constant, z, variable, _ in parts:
        lines += [each.format(z=z, tau=tau) for each in variable.remember]
        lines.append(f"{letter} = {variable.value.format(z=z)} / {constant}")
    shape = law.shape.of(law.variable).format(q="q", s=s)
    lines.append(f"f = ({shape}) * r" if law.second is not None else f"f = {shape}")
    states = [(z, variable) for _, _, z, variable, _ in parts if variable.remember]
    kept = [state_text(*each) for each in states]
    return FILE.substitute(
        equation=law.equation, words=law.in_words, head=HEAD, name=name,
        found="\n".join(f"{key}: {value}" for key, value in found.items()),
        constants="\n".join(
            f"{constant} = {size!r}  # [{variable.unit}] the largest that was recorded"
            for _, constant, _, variable, size in parts
        ),
        function=function_text(law.place, lines, c, [z for z, _ in states], f"Return the {law.place.unit}."),
        parameters="".join(f"\n        {parameter_text(one)}" for one in parameters_of(law, name, values)),
        states="".join(f"\n        {each}" for each in kept),
        stage=law.place.stage, gives=law.place.gives, refute=law.variable.refute,
    ).replace("    states=(\n    ),\n", "")  # fmt: skip


PROBE_NAME = "probe"
CHOICES = ("first", "shape", "second", "s", "tau", "size", "size2")
PROBE = Template("""\
$head

$function

EFFECT = Effect(
    name="$name",
    summary="all laws of a place",
    cites=("draft",),
    parameters=(Parameter("c_probe", "1", 0.0, 1.0, -1e9, 1e9, "amount", null=0.0), $parameters),
    states=($states),
    hooks=(hook(law, stage="$stage", gives="$gives"),),
)
""")


@dataclass(frozen=True, slots=True)
class Probe:
    """All laws of one place in one effect: numbers choose variables and shape."""

    effect: Effect
    variables: tuple[Variable, ...]

    def trial(self, amount: float, law: Law, s: float, tau: float) -> dict[str, float]:
        """Return the values at which the probe is a law."""
        shape = float(list(LAW_SHAPES.values()).index(law.shape))
        first, second = self._index(law.variable), self._index(law.second)
        values = (first, shape, second, s, tau, law.size, law.second_size)
        names = (f"{one}_{PROBE_NAME}" for one in CHOICES)
        return {f"c_{PROBE_NAME}": amount} | dict(zip(names, values, strict=True))

    def freed_for(self, law: Law) -> Effect:
        """Return the effect that leaves to a fit what a law does; few of them, for each is composed anew."""
        return _freed(self.effect, tuple(parameters_of(law, PROBE_NAME)))

    def _index(self, variable: Variable | None) -> float:
        return -1.0 if variable is None else float(self.variables.index(variable))


@cache
def _freed(effect: Effect, free: tuple[Parameter, ...]) -> Effect:
    named = {one.symbol: one for one in free}
    parameters = tuple(named.get(one.symbol) or replace(one, std=0.0) for one in effect.parameters)
    return replace(effect, parameters=parameters)


@cache
def probe(place: Place, *, has_temperature: bool) -> Probe:
    """Return the probe of a place; that of the sensor has every variable, for it shows what they are."""
    known = [one for one in LAW_VARIABLES.values() if has_temperature or one.name != "temperature"]
    variables = tuple(one for one in known if place.name in one.places or place.name == "sense")
    names = [f"z{i}_probe" for i in range(len(variables))]
    pairs = list(zip(names, variables, strict=True))
    lines = [each.format(z=z, tau="tau_probe") for z, one in pairs for each in one.remember]
    for letter, absent, chooser, size in (("q", 0.0, "first", "size"), ("r", 1.0, "second", "size2")):
        lines.append(f"{letter} = {absent}")
        for i, (z, one) in enumerate(pairs):
            value = f"    {letter} = {one.value.format(z=z)} / {size}_probe"
            lines += [f"if {chooser}_probe == {float(i)}:", value]
    lines.append("f = 0.0")
    for i, shape in enumerate(LAW_SHAPES.values()):
        lines += [f"if shape_probe == {float(i)}:", f"    f = {shape.text.format(q='q', s='s_probe')}"]
        lines += ["    f = f if q >= 0.0 else -f"] * shape.is_odd
    lines.append("f = f * r")
    states = [(z, one) for z, one in pairs if one.remember]
    text = PROBE.substitute(
        head=HEAD, name=f"probe_{place.name}", stage=place.stage, gives=place.gives,
        function=function_text(place, lines, "c_probe", [z for z, _ in states]),
        parameters=" ".join(f'Parameter("{one}_probe", "1", 1.0, 1.0, -1.0, 1e9, "-"),' for one in CHOICES),
        states=" ".join(state_text(*each) for each in states),
    )  # fmt: skip
    return Probe(effect_of(text, "the probe"), variables)
