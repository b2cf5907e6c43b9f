"""Where everything lies in the one array that an estimator owns: names instead of numbers.

One flat array per finger makes a call cheap (numba unpacks every argument) and saving a state trivial. The
generated module gets these places as constants: ``Y0`` is where the section ``Y`` begins, ``SET_DEPTH`` the
place of one named number. Kernels write ``m.y[i]`` and ``m.set.depth`` (:mod:`vegrip.model.writer`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

from vegrip.effects.contract import OUTSIDE
from vegrip.errors import ModelError
from vegrip.model import ContactModel

SETTINGS = (
    "ACCELERATION", "R_FORCE", "R_DISPLACEMENT", "R_RADIUS", "S_TANGENTIAL", "S_TORQUE", "LONGEST_GAP",
    "TIP_RADIUS", "DEPTH", "QUANTILE", "HORIZON", "HOLD", "SCATTER", "MU_DRIFT", "REGRASP",
    "MU_PRIOR_VAR", "HEALTH_TIME", "LEARNING_REST",
)  # fmt: skip

DELTA, SPEED, EFFECTS = 0, 1, 2
"""Places in the filter's state: indentation [m], its speed [m/s], and the first state of the effects."""

MODE = (
    "ZERO_KNOWN", "BLIND", "HEALTH_DECAY", "REGIME", "REST", "CELL", "SINCE_JERK", "PERIOD", "CAUTION",
    "CONTRADICTED", "UNEXPLAINED", "CORNER", "SLOPE",
    "TOLERATED", "LOST", "AGREED", "TOUCH", "FELT", "FREE_DEPTH", "ZERO_MEAN", "ZERO_VAR",
    "RADIUS_CONTRADICTED", "BEND", "MET",
)  # fmt: skip
"""What the filter is doing: times in [s], switches 0 or 1.

ZERO_KNOWN: the contact was felt to begin, so the zero of the displacement is known; BLIND: no displacement;
REST: since the tip moved in contact; SINCE_JERK: since the displacement jumped; PERIOD: of the samples;
CAUTION: time left in which nothing is learned; CONTRADICTED: for how long a published estimate has disagreed
with its own measurement; UNEXPLAINED: variance of the force [N^2] beyond what model and noise explain;
CORNER: how far the motion left a straight line within the last step [m];
SLOPE: of the force over the indentation when last used [N/m]; TOLERATED: the part of
UNEXPLAINED that counts as noise; LOST: for how long the contact has been lost; AGREED: since when nothing
contradicts; TOUCH: sum of the forces above the noise, in its std; FELT: whether the contact is felt;
FREE_DEPTH: largest displacement [m] at which it would have been felt and was not;
ZERO_MEAN [m], ZERO_VAR [m^2]: of the zero, without that bound; RADIUS_CONTRADICTED: for how long the radius
has disagreed with its own measurement; BEND: sum of the bends of the force [N] that are still the same; MET:
whether a contact was felt since the beginning.
"""

COUNTS = ("RESTARTS", "OVERFLOWS")
"""How often the memory of a lost contact was begun anew, and how often a number was not finite any more."""

MOTION = ("POSITION", "SPEED", "VAR_POSITION", "COV", "VAR_SPEED", "RESTLESS")
"""The measured displacement followed on its own, with constant speed: where the next sample is expected."""

REPORT = (
    "FORCE", "FORCE_STD", "RADIUS", "RADIUS_STD", "EXPONENT", "EXPONENT_STD", "MU", "MU_STD", "LIMIT_FORCE",
    "LIMIT_FORCE_STD", "LIMIT_TORQUE", "LIMIT_TORQUE_STD", "LIMIT_RADIUS", "LIMIT_RADIUS_STD", "GAUGE",
    "GAUGE_REL", "GAUGE_BY_FORCE", "GAUGE_ABS", "DEPTH_NOW", "DEPTH_STD", "CONTACT", "SOUND",
    "RADIUS_SOUND", "SLIDES",
)  # fmt: skip

FRICTION = (
    "LN_MU", "VAR", "BASE_LN", "BASE_VAR", "PEAK", "BEST", "SLIDING", "SMOOTH", "TOUCHING", "EVENTS",
    "PROVEN", "HELD_TIME", "HELD_LEAST", "SLIDE_COUNT", "SLIDE_MEAN", "UNCONFIRMED", "SCATTER_VAR",
    "EXPONENT", "EXPONENT_VAR", "COV", "BASE_EXPONENT", "BASE_EXPONENT_VAR", "BASE_COV", "LOAD",
    "EVENT", "EVENT_LN_U", "EVENT_NOISE", "LOADINGS",
)  # fmt: skip

CHANNELS = ("displacement", "normal_force", "contact_radius")
SHORT = ("DISPLACEMENT", "FORCE", "RADIUS")
"""The same in the names of constants: ``CHANNEL_FORCE``, ``FORCE_STREAK``."""
REGIMES = (
    "air", "loading", "hold", "unloading", "deep loading", "fast loading", "deep hold", "late hold",
    "deep unloading", "fast unloading", "sliding", "jerk",
)  # fmt: skip
"""In which the innovations are watched; those without a word are shallow and slow, or early."""
RATIO = ("COUNT", "PLACE")
"""Samples in the mean of the slopes, and the indentation [m] it belongs to; the slopes follow."""

NAMED = {
    "SET": ("SET", SETTINGS), "REPORT": ("REP", REPORT), "FRICTION": ("FRI", FRICTION),
    "MODE": ("MODE", MODE), "MOTION": ("MOTION", MOTION), "COUNTS": ("COUNT", COUNTS),
    "RATIO": ("RATIO", RATIO),
}  # fmt: skip
"""Section -> prefix and names of the numbers in it; their places are constants of their own."""

SCRATCH = "OLD"
"""The first of the sections that nothing is kept in from one sample to the next."""

ENDS = ("Y", "P", "H", "MODE")
"""Sections whose end the kernels ask for."""

WITHOUT_START = ("SET", "REPORT", "FRICTION", "MOTION", "COUNTS")
"""Sections of which the kernels use the names alone."""

BOUNDS = ("", "elastic_force", "force", "x")
"""What a state of unknown history may lie between; the place is the code the kernels know."""

MOVING = ("tip", "elastic", "force", "sense")
"""The stages that the force comes from."""

PER_CHANNEL = ("STREAK", "REJECTED", "AGE", "USED")
"""Refusals in a row, refusals in all, time since the last one used [s], whether the present one was."""
PER_CELL = ("WEIGHT", "MEAN", "NIS")
LOAD_PARTS = ("force", "torque")
PER_PART = ("AVERAGE", "LAST", "LEAST", "BEFORE", "BLOCK", "LOST")
"""Average and last value of a part of the load, the least of the average in this block of time and in the
one before, the age of the block [s], and for how long [s] it is doubted that the part is gone."""


@dataclass(frozen=True)
class Layout:
    """Sizes and places for one model."""

    n_states: int  # of the effects
    n_values: int  # parameters and geometry
    learned: tuple[int, ...]  # places of learned parameters in the vector of values
    learned_log: tuple[bool, ...]
    considered: tuple[int, ...]  # uncertain, not learned, but felt by radius, exponent, friction
    considered_log: tuple[bool, ...]
    mu: int  # place of the friction coefficient
    mu_learned: bool  # whether slip corrects it
    state_low: tuple[int, ...]  # see BOUNDS
    state_high: tuple[int, ...]
    state_share: tuple[int, ...]  # place of the parameter that scales both, or -1
    extreme: tuple[bool, ...]  # states of the effects that no measurement corrects
    speed_felt: bool  # whether any effect reads the speed

    @property
    def n(self) -> int:
        """Size of the filter's state: delta, speed, effect states, learned, offset d0, bias bF."""
        return self.bias + 1

    @property
    def learned_from(self) -> int:
        return EFFECTS + self.n_states

    @property
    def moving(self) -> int:
        """How many of its coordinates the model's force depends on; the offset follows."""
        return self.learned_from + len(self.learned)

    @property
    def bias(self) -> int:
        """Place of the force's bias in the filter's state; before it stands the displacement's offset."""
        return self.moving + 1

    def sections(self) -> dict[str, int]:
        """Name -> length of each section, in order."""
        n, s, spread = self.n, self.n_states, self.moving + len(self.considered) + 1
        return {
            "Y": n, "P": n * n, "VALUES": self.n_values, "EXOGENOUS": len(OUTSIDE),
            "PRIOR": n, "LOW": n, "HIGH": n, "DRIFT": n, "SET": len(SETTINGS),
            "FRICTION": len(FRICTION), "CONSIDER": len(self.considered), "REPORT": len(REPORT),
            "CHANNEL": len(CHANNELS) * len(PER_CHANNEL),
            "HEALTH": len(CHANNELS) * len(REGIMES) * len(PER_CELL),
            "MODE": len(MODE), "MOTION": len(MOTION), "START": n, "COUNTS": len(COUNTS),
            "BEND_SUM": s + 1, "RATIO": n, "PART": len(LOAD_PARTS) * len(PER_PART),
            "OLD": n, "KEPT_Y": n, "KEPT_P": n * n,
            "F": (s + 1) * n, "B": n * n, "H": n, "G": n, "K": n, "BEND": s + 1,
            "NEXT": s + 1, "TRIAL": s + 1, "L": n * n,
            "D_FORCE": spread, "D_RADIUS": spread, "D_EXPONENT": spread, "D_FRICTION": spread,
            "D_DELTA": spread, "D_SHAPE": spread, "TRIED": n, "MID": n,
        }  # fmt: skip

    def places(self) -> dict[str, tuple[int, int]]:
        """Name -> start and end of each section."""
        out, at = {}, 0
        for name, length in self.sections().items():
            out[name] = (at, at + length)
            at += length
        return out

    @property
    def size(self) -> int:
        return sum(self.sections().values())

    @property
    def lasting(self) -> int:
        """Length of what the next sample depends on; all behind it is worked out anew with every sample."""
        return self.places()[SCRATCH][0]

    def names(self) -> dict[str, object]:
        return dict(self._sizes()) | dict(self._tables()) | dict(self.named_places())

    def constants(self) -> str:
        return "\n".join(f"{name} = {value}" for name, value in self.names().items())

    def _sizes(self) -> Iterator[tuple[str, object]]:
        yield from {"N": self.n, "M": self.moving, "NS": self.n_states}.items()
        yield from {"N_LEARNED": len(self.learned), "N_CONSIDERED": len(self.considered)}.items()
        yield from {"DELTA": DELTA, "SPEED": SPEED, "EFFECTS": EFFECTS}.items()
        yield from {"LEARNED_FROM": self.learned_from, "OFFSET": self.moving, "BIAS": self.bias}.items()
        yield from {"MU_PLACE": self.mu, "CONSIDERED_MU": self.considered.index(self.mu)}.items()
        yield from {"CHANNELS": len(CHANNELS), "CHANNEL_SIZE": len(PER_CHANNEL)}.items()
        yield from ((f"CHANNEL_{short}", i) for i, short in enumerate(SHORT))
        yield from ((f"CH_{name}", i) for i, name in enumerate(PER_CHANNEL))
        yield from {"REGIMES": len(REGIMES), "CELL_SIZE": len(PER_CELL)}.items()
        yield from ((f"CELL_{name}", i) for i, name in enumerate(PER_CELL))
        yield "PART_SIZE", len(PER_PART)
        yield from ((f"PART_{name}", i) for i, name in enumerate(PER_PART))
        words = (name.upper().replace(" ", "_") for name in REGIMES)
        yield from ((f"REGIME_{word}", float(i)) for i, word in enumerate(words))

    def _tables(self) -> Iterator[tuple[str, object]]:
        """What is known of each parameter and state; one more entry, because a tuple must not be empty."""
        free = (False,) * (self.n - self.learned_from)
        yield "LEARNED", (*self.learned, -1)
        yield "LEARNED_LOG", (*self.learned_log, False)
        yield "CONSIDERED", (*self.considered, -1)
        yield "CONSIDERED_LOG", (*self.considered_log, False)
        yield "STATE_LOW", (*self.state_low, 0)
        yield "STATE_HIGH", (*self.state_high, 0)
        yield "STATE_SHARE", (*self.state_share, -1)
        yield "KEPT", (False, False, *self.extreme, *free)
        yield "FELT", (True, self.speed_felt, *[True] * (self.n - EFFECTS))

    def named_places(self) -> Iterator[tuple[str, int]]:
        """Where the sections begin, and the numbers in them that have names."""
        for section, (start, end) in self.places().items():
            if section not in WITHOUT_START:
                yield f"{section}0", start
            if section in ENDS:
                yield f"{section}1", end
            prefix, names = NAMED.get(section, ("", ()))
            yield from ((f"{prefix}_{name}", start + i) for i, name in enumerate(names))
        for channel, name in (("DISPLACEMENT", "STREAK"), ("DISPLACEMENT", "AGE"), ("FORCE", "STREAK")):
            yield f"{channel}_{name}", self.channel_place(SHORT.index(channel), name)

    def channel_place(self, channel: int, name: str) -> int:
        """Return where a number of :data:`PER_CHANNEL` of a channel lies."""
        return self.places()["CHANNEL"][0] + channel * len(PER_CHANNEL) + PER_CHANNEL.index(name)


def layout_of(model: ContactModel) -> Layout:
    """Return the layout for ``model``."""
    names = list(model.parameters)
    reading, moving = _taken(model, ("area", "profile", "friction")), _taken(model, MOVING)
    mu = friction_symbol(model)
    learned = [n for n in names if n in moving and model.values[n].learn and model.values[n].std > 0.0]
    considered = [n for n in names if n in reading - moving and n != mu and model.values[n].std > 0.0]
    log = {n: declared.transform == "log" for n, (_, declared) in model.parameters.items()}
    states = [s for e in model.effects for s in e.states]
    taken = {name for calls in model.plan.calls.values() for call in calls for name in call.takes}
    return Layout(
        speed_felt="speed" in taken,
        state_low=tuple(BOUNDS.index(s.low) for s in states),
        extreme=tuple(s.extreme for s in states),
        state_share=tuple(names.index(s.share) if s.share else -1 for s in states),
        state_high=tuple(BOUNDS.index(s.high) for s in states),
        n_states=len(model.plan.states),
        n_values=len(names) + 3,
        learned=tuple(names.index(n) for n in learned),
        learned_log=tuple(log[n] for n in learned),
        considered=tuple(names.index(n) for n in [*considered, mu]),
        considered_log=tuple(log[n] for n in [*considered, mu]),
        mu=names.index(mu),
        mu_learned=model.values[mu].learn,
    )


def state_names(model: ContactModel, layout: Layout) -> tuple[str, ...]:
    """Return the names of the filter's state in its order, such as ``indentation`` and ``ln K``."""
    symbols = list(model.parameters)
    learned = [
        f"ln {symbols[place]}" if log else symbols[place]
        for place, log in zip(layout.learned, layout.learned_log, strict=True)
    ]
    return ("indentation", "speed", *model.plan.states, *learned, "displacement_offset", "force_bias")


def _taken(model: ContactModel, stages: tuple[str, ...]) -> set[str]:
    return {name for stage in stages for call in model.plan.calls[stage] for name in call.takes}


def friction_symbol(model: ContactModel) -> str:
    """Return the symbol of the friction coefficient: what the effect that defines friction takes."""
    definition = model.plan.calls["friction"][0]
    moving = _taken(model, MOVING)  # what the force depends on (a stiffness as reference) is learned from it
    taken = [name for name in definition.takes if name in model.parameters and name not in moving]
    if not taken:
        raise ModelError(
            f"the effect {definition.effect} defines friction without a parameter; the estimator needs a "
            "friction coefficient, such as mu of coulomb_friction"
        )
    return next((name for name in taken if model.values[name].learn), taken[0])
