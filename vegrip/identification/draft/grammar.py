"""The grammar of drafted laws: what may depend on what, and how; and the text of an effect that says so.

A law multiplies or shifts one quantity of the model, its *place*, by a *shape* of one *variable*, perhaps
times a second variable::

    place * (1 + c f(q))      or      place + c K f(q),      q = variable / SIZE

SIZE is the largest value of the variable that was recorded, so c is the change there. A variable may need a
memory, which is the hidden state of the law. The same text serves the search, where one function holds all
variables and shapes and numbers choose among them, and the file of the law that was found.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Place:
    """Where a law acts: a stage of the recursion and what it gives there (vegrip/effects/contract.py)."""

    name: str
    stage: str
    gives: str
    law: str  # in words, with {f}
    text: str  # with {f}, the shape, and {c}
    where: str  # force law, memory or sensor
    unit: str


LAW_PLACES = {
    one.name: one
    for one in (
        Place("elastic", "elastic", "elastic_force", "N_e *= 1 + c {f}",
              "elastic_force * max(1.0 + {c} * {f}, 0.0)", "force law", "elastic force [N]"),
        Place("spring", "elastic", "elastic_force", "N_e += c K {f} in contact",
              "elastic_force + ({c} * K * {f} if x > 0.0 else 0.0)", "force law", "elastic force [N]"),
        Place("force", "force", "force", "N *= 1 + c {f}",
              "force * max(1.0 + {c} * {f}, 0.0)", "force law", "force [N]"),
        Place("pull", "force", "force", "N += c K {f} in contact",
              "force + ({c} * K * {f} if x > 0.0 else 0.0)", "force law", "force [N]"),
        Place("rate", "tip", "relaxation_rate", "rates of relaxation *= 1 + c {f}",
              "relaxation_rate * max(1.0 + {c} * {f}, 0.01)", "memory", "factor on the rates of relaxation"),
        Place("strength", "tip", "relaxation_strength", "what relaxes *= 1 + c {f}",
              "relaxation_strength * max(1.0 + {c} * {f}, 0.0)", "memory", "factor on what relaxes"),
        Place("sense", "sense", "sensed_force", "sensor += c K {f}",
              "sensed_force + {c} * K * {f}", "sensor", "force that the sensor shows [N]"),
    )
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Variable:
    """What a law may depend on; ``remember`` updates the state ``{z}`` of those that need one."""

    name: str
    words: str
    unit: str
    value: str
    remember: tuple[str, ...] = ()
    state_unit: str = ""
    places: tuple[str, ...] = ("elastic", "spring", "force", "pull", "rate", "strength")
    is_lasting: bool = False
    is_signed: bool = False
    kin: str = ""  # the variable that it is without its memory
    refute: str = ""

    @property
    def has_rate(self) -> bool:
        return "{tau}" in "".join(self.remember)


X, RATE = "(x / reference_depth)", "(abs(speed) / reference_depth)"
SLOW = ("force", "rate", "strength", "sense")
KEPT = ("force", "pull", "rate", "strength")
WHOLE = "math.floor({z}) == {z}"  # in the air; in contact a half
COUNT = f"{{z}} = {{z}} + 0.5 if (x > 0.0 and {WHOLE}) or (x <= 0.0 and not {WHOLE}) else {{z}}"
AHEAD = f"(max({X}, 0.0) - {{z}})"
LAG = "{z} = {z} + ({q} - {z}) * (1.0 - math.exp(-dt / {tau}))"

LAW_VARIABLES = {
    one.name: one
    for one in (
        Variable("depth", "the indentation", "x_ref", f"max({X}, 0.0)",
                 refute="slow presses to half as deep again"),
        Variable("load", "the elastic force", "K", "(elastic_force / K)", places=("force", "pull", "sense"),
                 refute="slow presses to twice the force"),
        Variable("speed", "the speed, with its sign", "x_ref/s", "(speed / reference_depth)", is_signed=True,
                 refute="triangles over three decades of speed"),
        Variable("rate", "the speed, whatever its sign", "x_ref/s", RATE,
                 refute="triangles over three decades of speed, and holds between"),
        Variable("deepest", "the deepest indentation so far", "x_ref", "{z}",
                 (f"{{z}} = max({{z}}, {X})",), "1", is_lasting=True,
                 refute="triangles of growing peak, then back to a small one"),
        Variable("below", "how far the indentation is below the deepest one", "x_ref",
                 f"({{z}} - max({X}, 0.0))", (f"{{z}} = max({{z}}, {X})",), "1", is_lasting=True,
                 refute="triangles of growing peak, then back to a small one"),
        Variable("deepest_here", "the deepest indentation in this contact", "x_ref", "{z}",
                 (f"{{z}} = max({{z}}, {X}) if x > 0.0 else 0.0",), "1", places=KEPT,
                 refute="presses just short of a depth and just past it, in and out"),
        Variable("contact_time", "the time in this contact", "s", "{z}",
                 ("{z} = {z} + dt if x > 0.0 else 0.0",), "s", places=KEPT,
                 refute="a hold ten times as long"),
        Variable("time", "the time recorded so far", "s", "{z}", ("{z} = {z} + dt",), "s", is_lasting=True,
                 places=SLOW, refute="the same press again after an hour"),
        Variable("presses", "the number of presses so far", "1", "{z}", (COUNT,), "1", is_lasting=True,
                 places=KEPT, refute="ten presses at once, then one after an hour"),
        Variable("way", "the way rubbed in and out so far", "x_ref", "{z}",
                 (f"{{z}} = {{z}} + ({RATE} * dt if x > 0.0 else 0.0)",), "1", is_lasting=True, places=KEPT,
                 refute="a hundred small presses, then a large one"),
        Variable("work", "the work done on the tip so far", "K x_ref", "{z}",
                 (f"{{z}} = {{z}} + elastic_force / K * {RATE} * dt",), "1", is_lasting=True,
                 places=("force", "pull"), refute="many presses, deep in one recording, shallow in another"),
        Variable("impulse", "the load times the time so far", "K s", "{z}",
                 ("{z} = {z} + max(elastic_force, 0.0) / K * dt",), "s", is_lasting=True,
                 places=("force", "pull"), refute="a long hold, deep in one recording, shallow in another"),
        Variable("recent_depth", "a memory of the indentation", "x_ref", "{z}",
                 (LAG.replace("{q}", f"max({X}, 0.0)"),), "1", is_lasting=True, places=KEPT, kin="depth",
                 refute="holds of very different length"),
        Variable("recent_load", "a memory of the elastic force", "K", "{z}",
                 (LAG.replace("{q}", "elastic_force / K"),), "1", is_lasting=True, places=("force", "pull"),
                 kin="load", refute="holds of very different length and depth"),
        Variable("ahead", "how far the indentation is ahead of a memory of it", "x_ref", AHEAD,
                 (LAG.replace("{q}", f"max({X}, 0.0)"),), "1", places=KEPT, is_signed=True, kin="depth",
                 refute="steps of different size and quickness, each with a hold"),
        Variable("away", "how far the indentation is from a memory of it", "x_ref", f"abs({AHEAD})",
                 (LAG.replace("{q}", f"max({X}, 0.0)"),), "1", places=("rate", "strength"), kin="depth",
                 refute="steps of different size and quickness, each with a hold"),
        Variable("recent_rate", "a memory of how fast it moved", "x_ref/s", "{z}",
                 (LAG.replace("{q}", RATE),), "1/s", places=KEPT, kin="rate",
                 refute="sines of growing frequency, then a slow press at once"),
        Variable("recent_contact", "a memory of being touched", "1", "{z}",
                 (LAG.replace("{q}", "(1.0 if x > 0.0 else 0.0)"),), "1", is_lasting=True, places=SLOW,
                 refute="presses with pauses of very different length"),
        Variable("temperature", "the temperature above the reference", "degC",
                 "(temperature - reference_temperature)", places=("elastic", *SLOW), is_signed=True,
                 refute="the same press at three temperatures"),
    )
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Shape:
    """How a law depends on q; ``{s}`` shapes it, from ``low`` to ``high``, tried at ``trials``.

    ``is_odd``: a variable of both signs gives the shape its sign.
    """

    name: str
    words: str  # with q and s, for q >= 0
    text: str
    trials: tuple[float, ...] = ()
    low: float = 0.0
    high: float = 0.0
    is_odd: bool = False
    of_what: tuple[str, ...] = ()  # variables that it is for, of some alone

    @property
    def middle(self) -> float:
        return self.trials[len(self.trials) // 2] if self.trials else 1.0

    def of(self, variable: Variable) -> str:
        """Return the expression for a variable."""
        return (
            f"(1.0 if {{q}} >= 0.0 else -1.0) * {self.text}"
            if self.is_odd and variable.is_signed
            else self.text
        )

    def in_words(self, variable: Variable) -> str:
        return (
            f"sign(q) {self.words.replace('q', '|q|')}" if self.is_odd and variable.is_signed else self.words
        )


LAW_SHAPES = {
    one.name: one
    for one in (
        Shape("linear", "q", "{q}"),
        Shape("power", "q^s", "abs({q}) ** {s}", (0.5, 2.0, 4.0), 0.1, 8.0, is_odd=True),
        Shape("saturating", "(1 - exp(-q / s))", "(1.0 - math.exp(-abs({q}) / {s}))", (0.05, 0.2, 0.6), 0.005,
              5.0, is_odd=True),
        Shape("beyond", "max(q - s, 0)", "max({q} - {s}, 0.0)", (0.2, 0.35, 0.5, 0.65, 0.8), 0.01, 1.0),
        Shape("step", "(1/2 + tanh((q - s) / 0.02) / 2)", "(0.5 + 0.5 * math.tanh(({q} - {s}) / 0.02))",
              (0.1, 0.25, 0.5, 0.75, 0.9), 0.01, 1.0, of_what=("time", "presses", "way", "deepest_here")),
    )
}  # fmt: skip
MEMORY_TIMES_S = (0.1, 1.0, 10.0, 100.0)  # [s] at which a memory is tried


def _over(variable: Variable, size: float) -> str:
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    return f"{variable.words} over {size:.4g}{unit}"


@dataclass(frozen=True, slots=True)
class Law:
    """One sentence of the grammar; sizes are the largest values that were recorded."""

    place: Place
    variable: Variable
    shape: Shape
    size: float
    second: Variable | None = None
    second_size: float = 1.0

    @property
    def equation(self) -> str:
        f = self.shape.in_words(self.variable) + " r" * (self.second is not None)
        return self.place.law.format(f=f)

    @property
    def variables(self) -> list[str]:
        return [self.variable.name, *([self.second.name] if self.second else [])]

    @property
    def in_words(self) -> str:
        """The law with what its letters are."""
        at = f"q: {self.scaled}"
        if self.second is not None:
            at += f"; r: {_over(self.second, self.second_size)}"
        return f"{self.equation}; {at}"

    @property
    def scaled(self) -> str:
        """What q is, over its size."""
        return _over(self.variable, self.size)

    @property
    def complexity(self) -> int:
        states = sum(bool(one.remember) for one in (self.variable, self.second) if one)
        return 1 + bool(self.shape.trials) + self.variable.has_rate + states + 2 * (self.second is not None)
