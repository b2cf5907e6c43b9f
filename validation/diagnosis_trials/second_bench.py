"""A second bench: recordings of a simulator that shares no code with the model or with the virtual bench.

One fingertip in small steps: a power law or what is hidden of it, one relaxing branch with a free surface,
the paper's coupling of pressure and radius, and Coulomb friction that is rigid until it slides, pulled or
twisted, never both. The laws that may be hidden are those of the catalogue, written anew from the equations.
What comes out is what sensors show: columns in SI.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import beta, gammaln

Array = np.ndarray
STEP_S = 1e-3  # [s] of the simulation
PAUSE_S = 12.0  # [s] between episodes
RISE_S = 0.1  # [s] to a force that is held
STIFF = 40.0  # [load at slip / mm] tangential: rigid until slip, but for a rise of the load that is seen
RIM_SHARE = 0.67  # of the radius, at which a twist slides
LEAST_LOAD_N = 1e-9  # for what divides by the largest load
PROFILES = np.linspace(1.5, 30.0, 400)  # of the pressure exponent


def peak_of(k: Array) -> Array:
    """Return C_k, the pressure in the middle over the mean."""
    out: Array = np.exp(gammaln(1.0 + 3.0 / k) - gammaln(1.0 + 1.0 / k) - gammaln(1.0 + 2.0 / k))
    return out


def twist_of(k: Array) -> Array:
    """Return the torque at slip over mu N a."""
    out: Array = 2.0 * peak_of(k) / k * beta(3.0 / k, 1.0 + 1.0 / k)
    return out


PEAKS, TWISTS = peak_of(PROFILES), twist_of(PROFILES)


@dataclass(frozen=True)
class Tip:
    """A fingertip: radius [m], force [N] at a depth of 1 mm, exponent, one branch, friction."""

    radius: float
    force: float
    exponent: float
    share: float
    rate: float
    friction: float


@dataclass(frozen=True)
class Move:
    """One stretch of an episode: to a depth [m] or a held force [N], with a sine, a pull or a twist."""

    seconds: float
    depth: float | None = None
    force: float | None = None
    wave: tuple[float, float] = (0.0, 0.0)  # [m], [Hz]
    pull: float = 0.0  # [m/s]
    spin: float = 0.0  # [rad/s]


@dataclass
class Laws:
    """What is hidden, by the names of the catalogue; amounts in SI."""

    hidden: Mapping[str, Mapping[str, float]]
    deepest: float = 0.0

    def of(self, name: str) -> Mapping[str, float] | None:
        return self.hidden.get(name)

    def elastic(self, tip: Tip, x: float) -> float:
        """Return the elastic force [N] at the indentation ``x`` [m]."""
        if x <= 0.0:
            return 0.0
        force = tip.force * (1e3 * x) ** tip.exponent
        if e := self.of("exponential_stiffness"):
            force *= math.expm1(x / e["length"]) / (x / e["length"])
        if e := self.of("layer_over_core"):
            X = math.sqrt(tip.radius * x) / e["thickness"]
            force *= 1.0 + X * (1.133 + X * (e["second"] + X * (e["third"] + X * e["fourth"])))
            force += e.get("core", 0.0) * max(1e3 * (x - e.get("at", 1.0)), 0.0) ** 1.5
        if e := self.of("second_contact"):
            force += e["force"] * max(1e3 * (x - e["at"]), 0.0) ** e["exponent"]
        for name in ("mullins_softening", "healing_softening"):
            if e := self.of(name):
                top = max(self.deepest, x)
                near = math.tanh((top - x) / e["width"]) if "width" in e else 1.0 - x / top
                force *= 1.0 - e["loss"] * near
        return float(force)

    def close(self, x: float, dt: float) -> None:
        """Remember a step of ``dt`` [s] at ``x`` [m], or a pause."""
        self.deepest = max(self.deepest, x)
        if (e := self.of("healing_softening")) and x <= 0.0:
            self.deepest *= math.exp(-e["rate"] * dt)

    def friction(self, tip: Tip, load: float, speed: float, age: float) -> float:
        """Return mu at the load [N], slip speed [m/s] and age of the contact [s]."""
        mu = tip.friction
        if e := self.of("load_dependent_friction"):
            mu *= (max(load, 1e-3) / e["at"]) ** -e["exponent"]
        if e := self.of("rate_dependent_friction"):
            mu *= e["kinetic"] + (1.0 - e["kinetic"]) * math.exp(-((speed / e["stribeck"]) ** 2))
            mu *= 1.0 + e["growth"] * math.log1p(speed / e["slow"])
        if e := self.of("friction_ageing"):
            mu *= 1.0 + e["growth"] * math.log1p(age / e["time"])
        return mu


ROWS = ("t", "episode", "x", "N", "a", "f", "q", "slip", "speed")
"""What is true in each step; f [N] and q [N m] are what the contact carries."""


class Contact:
    """A fingertip and what its contact remembers, in steps of ``dt`` [s]."""

    def __init__(self, tip: Tip, laws: Laws, dt: float) -> None:
        self.tip, self.laws, self.dt = tip, laws, dt
        self.renewal = (laws.of("friction_ageing") or {}).get("distance", 1e-5)  # [m]
        self.recover()

    def recover(self) -> None:
        """Begin an episode: what relaxes and ages is as new."""
        self.x = self.elastic = self.branch = self.load = self.age = 0.0
        self.largest = LEAST_LOAD_N
        self.begin()

    def begin(self) -> None:
        """Begin a move: nothing is slid yet."""
        self.way = self.angle = 0.0
        self.is_sliding = False

    def depth_at(self, want: float) -> float:
        """Return the indentation [m] at which the load is ``want`` [N] at the end of this step."""

        def over(x: float) -> float:
            elastic = self.laws.elastic(self.tip, x)
            return elastic - self.tip.share * self._relaxed(elastic) - want

        high = max(2.0 * self.x, 2e-4)
        while over(high) < 0.0 and high < self.tip.radius:
            high *= 1.5
        return float(brentq(over, 0.0, high, xtol=1e-10)) if over(0.0) < 0.0 < over(high) else self.x

    def press(self, x: float) -> None:
        """Go to the indentation ``x`` [m]."""
        self.x, c = x, self.tip.share
        elastic = self.laws.elastic(self.tip, x)
        branch = self._relaxed(elastic)
        self.load = elastic - c * branch
        if self.load < 0.0:  # a free surface, whose elastic force is what the branch holds
            branch = self.branch * math.exp(-self.tip.rate * (1.0 - c) * self.dt)
            elastic, self.load = c * branch, 0.0
        self.elastic, self.branch = elastic, branch
        self.laws.close(x if self.load > 0.0 else min(x, 0.0), self.dt)
        self.largest = max(self.largest, self.load) if self.load > 0.0 else LEAST_LOAD_N
        self.age = self.age + self.dt if self.load > 0.0 else 0.0

    def _relaxed(self, elastic: float) -> float:
        """Return the branch after a step that ends at ``elastic`` [N], by the trapezoid."""
        h = 0.5 * self.tip.rate * self.dt
        return (self.branch * (1.0 - h) + h * (self.elastic + elastic)) / (1.0 + h)

    @property
    def radius(self) -> float:
        return math.sqrt(2.0 * self.tip.radius * self.x) if self.load > 0.0 else 0.0

    @property
    def arm(self) -> float:
        """Torque at slip over mu N [m], of the profile that creep has flattened."""
        alone = 1e-3 * (self.largest / self.tip.force) ** (1.0 / self.tip.exponent)  # what is hidden left out
        k = np.interp(max(1.5 / max(self.x / alone, 1.0), PEAKS[-1]), PEAKS[::-1], PROFILES[::-1])
        return float(np.interp(k, PROFILES, TWISTS)) * self.radius

    def drag(self, pull: float, spin: float) -> tuple[float, float, float, float]:
        """Pull [m/s] or spin [rad/s] for a step; return the last four of :data:`ROWS`."""
        if not (pull or spin) or self.load <= 0.0:
            return 0.0, 0.0, 0.0, 0.0
        self.way += abs(pull) * self.dt
        self.angle += abs(spin) * self.dt
        rim = RIM_SHARE * self.radius
        moved, v = (self.way, abs(pull)) if pull else (self.angle * rim, abs(spin) * rim)
        limit = self.load * self.laws.friction(self.tip, self.load, v if self.is_sliding else 0.0, self.age)
        carried, is_felt, is_whole = self._share(moved)
        if is_whole:
            self.is_sliding = True
            self.age *= math.exp(-v * self.dt / self.renewal)
        held = carried * limit
        return (held if pull else 0.0), (0.0 if pull else held * self.arm), float(is_felt), v * is_whole

    def _share(self, moved: float) -> tuple[float, bool, bool]:
        """Return the share of the limit that is carried, whether slip is felt, and whether all slides."""
        kick = self.laws.of("presliding")
        if kick is None:
            carried = min(moved * 1e3 * STIFF, 1.0)
            return carried, carried >= 1.0, carried >= 1.0
        slipped = min(moved / kick["distance"], 1.0)  # of the area: 1 - (c / a)^2
        is_felt = slipped >= kick["felt"]
        is_whole = slipped >= 1.0 or (kick["speed_at_once"] > 0.0 and is_felt)
        return 1.0 - (1.0 - slipped) ** 1.5, is_felt, is_whole


def simulate(
    tip: Tip, laws: Laws, episodes: Sequence[Sequence[Move]], dt: float = STEP_S
) -> dict[str, Array]:
    """Return what was true, one row a step, by the names of :data:`ROWS`."""
    contact, t = Contact(tip, laws, dt), 0.0
    rows: list[tuple[float, ...]] = []
    for number, moves in enumerate(episodes):
        contact.recover()
        for move in moves:
            contact.begin()
            begin, count = contact.x, max(1, round(move.seconds / dt))
            end = begin if move.depth is None else move.depth
            size, hertz = move.wave
            for i in range(1, count + 1):
                s = i * dt
                if move.force is None:
                    wave = size * math.sin(2.0 * math.pi * hertz * s)
                    contact.press(begin + (end - begin) * i / count + wave)
                else:
                    contact.press(contact.depth_at(move.force * min(s / RISE_S, 1.0)))
                dragged = contact.drag(move.pull, move.spin)
                rows.append((t + s, number, contact.x, contact.load, contact.radius, *dragged))
            t += count * dt
        laws.close(-1.0, PAUSE_S)
        t += PAUSE_S
    return dict(zip(ROWS, np.array(rows).T, strict=True))


def sensed(
    true: Mapping[str, Array], rate: float, noise: Mapping[str, float], rng: np.random.Generator,
    *, delay: float = 0.0, lag: float = 0.0, sees: bool = False,
) -> dict[str, Array]:  # fmt: skip
    """Return what sensors show at ``rate`` [Hz] with white ``noise``; ``delay`` and ``lag`` [s]."""
    t, force = true["t"], true["N"].copy()
    starts = np.flatnonzero(np.r_[True, np.diff(true["episode"]) != 0]).tolist()
    shown = np.empty_like(force)
    for begin, end in zip(starts, [*starts[1:], t.size], strict=True):
        here = slice(begin, end)
        shown[here] = np.interp(t[here] - delay, t[here], force[here], left=0.0)
        if lag:
            y = 0.0
            for i in range(begin, end):
                y += -math.expm1(-(t[1] - t[0]) / lag) * (0.5 * (shown[i] + shown[max(i - 1, begin)]) - y)
                force[i] = y
            shown[here] = force[here]
    rows = np.flatnonzero(np.arange(t.size) % round(1.0 / (rate * (t[1] - t[0]))) == 0)

    def with_noise(values: Array, name: str) -> Array:
        out: Array = values[rows] + noise[name] * rng.standard_normal(rows.size)
        return out

    columns = {
        "t": t[rows],
        "episode": true["episode"][rows],
        "displacement": with_noise(true["x"], "displacement"),
        "normal_force": with_noise(shown, "normal_force"),
        "tangential_force_x": with_noise(true["f"], "tangential_force"),
        "tangential_force_y": with_noise(0.0 * t, "tangential_force"),
        "torque_z": with_noise(true["q"], "torque_z"),
        "slip": true["slip"][rows],
        "slip_speed": true["speed"][rows],
    }
    if sees:
        columns["contact_radius"] = with_noise(true["a"], "contact_radius")
        columns["contact_radius"][true["N"][rows] <= 0.0] = np.nan
    return columns


def draw_tip(rng: np.random.Generator) -> Tip:
    return Tip(
        radius=float(rng.uniform(6e-3, 12e-3)),
        force=float(rng.uniform(0.8, 2.5)),
        exponent=float(rng.uniform(1.35, 1.7)),
        share=float(rng.uniform(0.12, 0.35)),
        rate=float(np.exp(rng.uniform(np.log(0.8), np.log(5.0)))),
        friction=float(rng.uniform(0.5, 1.1)),
    )


def bench(tip: Tip, depth: float, rng: np.random.Generator) -> list[list[Move]]:
    """Holds, a creep, triangles, sines, pulls after short and long rests, twists, slides at three speeds."""
    clear = Move(0.3, depth=-0.1 * depth)

    def press(part: float, seconds: float, rise: float = 0.1) -> list[Move]:
        return [Move(rise, depth=part * depth), Move(seconds)]

    def slide(part: float, wait: float, v: float = 0.4, spin: float = 0.0) -> list[Move]:
        seconds = min(0.6 / v, 2.0) if not spin else 1.0
        pulled = Move(seconds, pull=0.0 if spin else v * depth, spin=spin)
        return [Move(0.15, depth=part * depth), Move(wait), pulled]

    def triangle(speed: float) -> list[Move]:
        return [Move(0.8 / speed, depth=0.8 * depth), Move(0.8 / speed, depth=-0.1 * depth)] * 2

    force = tip.force * (0.5e3 * depth) ** tip.exponent
    inside = [
        *(press(part, 4.0) for part in (0.4, 0.7, 1.0)),
        [Move(4.0, force=force)],
        *(triangle(speed) for speed in (0.4, 2.0, 10.0)),
        [*press(0.6, 0.5), Move(6.0, wave=(0.2 * depth, 0.5))],
        [*press(0.6, 0.5), Move(2.0, wave=(0.15 * depth, 5.0))],
        *(slide(part, wait) for part in (0.4, 0.6, 0.9) for wait in (0.3, 4.0)),
        *(slide(part, 0.5, spin=0.6) for part in (0.4, 0.8)),
        *(slide(0.7, 0.5, v) for v in (0.2, 1.0, 4.0)),
    ]
    order = rng.permutation(len(inside)) if rng.random() < 0.5 else range(len(inside))
    away = Move(0.3, depth=-0.1 * depth)
    return [[clear, *inside[i], away, Move(0.5)] for i in order]


def short(_: Tip, depth: float, rng: np.random.Generator) -> list[list[Move]]:
    """Return five presses and five slips."""
    clear = Move(0.3, depth=-0.1 * depth)
    presses = [
        [Move(float(rng.uniform(0.05, 0.5)), depth=float(part) * depth), Move(1.5)]
        for part in rng.uniform(0.3, 1.0, 5)
    ]
    slips = []
    for _slip in range(5):
        v = 0.4 * depth * float(rng.uniform(0.5, 3.0))
        turns = rng.random() < 0.2
        pulled = Move(0.8, pull=0.0 if turns else v, spin=0.6 if turns else 0.0)
        slips.append([
            Move(0.1, depth=float(rng.uniform(0.3, 0.9)) * depth), Move(float(rng.uniform(0.1, 2.0))), pulled
        ])  # fmt: skip
    return [[clear, *one, Move(0.2, depth=-0.1 * depth), Move(0.3)] for one in (*presses, *slips)]


def use(_: Tip, depth: float, rng: np.random.Generator) -> list[list[Move]]:
    """Return a dozen grasps at any speed, whose grip changes, half of them with a slide."""
    clear = Move(0.3, depth=-0.1 * depth)

    def grasp() -> list[Move]:
        first, speed = float(rng.uniform(0.3, 1.0)), float(np.exp(rng.uniform(np.log(0.5), np.log(20.0))))
        moves = [clear, Move(first / speed, depth=first * depth)]
        for _ in range(4):
            moves.append(Move(float(rng.uniform(0.05, 0.8)), depth=float(rng.uniform(0.3, 1.0)) * depth))
            moves.append(Move(float(rng.uniform(0.05, 0.8))))
        if rng.random() < 0.6:
            turns = rng.random() < 0.2
            v = 0.4 * depth * float(np.exp(rng.uniform(np.log(0.3), np.log(4.0))))
            moves.append(Move(0.8, pull=0.0 if turns else v, spin=0.6 if turns else 0.0))
        return [*moves, Move(float(rng.uniform(0.05, 0.5)), depth=-0.1 * depth), Move(0.3)]

    return [grasp() for _ in range(12)]


PROTOCOLS: Mapping[str, Callable[[Tip, float, np.random.Generator], list[list[Move]]]] = {
    "bench": bench,
    "short": short,
    "use": use,
}


@dataclass(frozen=True)
class Setting:
    """What amounts are measured by: tip, greatest depth [m], noise of the force [N], size, draws."""

    tip: Tip
    depth: float
    noise: float
    size: float
    rng: np.random.Generator

    @property
    def force(self) -> float:
        return float(self.tip.force * (1e3 * self.depth) ** self.tip.exponent)

    def between(self, low: float, high: float) -> float:
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))


BONDED = (1.283, 0.769, 0.0975), (1.497, 1.469, 0.755)
"""Coefficients of a bonded layer: Dimitriadis et al. (2002), and Garcia and Garcia (2018)."""


def _layer(s: Setting) -> dict[str, float]:
    """A bonded layer, a core that is met at a depth, or both."""
    kind = str(s.rng.choice(["layer", "core", "both"]))
    thin = s.between(0.8, 1.6) * s.tip.radius / s.size if kind != "core" else math.inf
    law = dict(zip(("second", "third", "fourth"), BONDED[int(s.rng.integers(2))], strict=True))
    at = s.between(0.2, 0.7) * s.depth
    core = s.between(0.1, 0.4) * s.size * s.force / (1e3 * (s.depth - at)) ** 1.5
    return law | {"thickness": thin, "core": core if kind != "layer" else 0.0, "at": at}


def _width(s: Setting) -> dict[str, float]:
    return {"width": s.between(0.2, 0.6) * s.depth} if s.rng.random() < 0.7 else {}


def _jump(s: Setting, size: float) -> dict[str, float]:
    return {"size": size * float(s.rng.choice([-1.0, 1.0])), "when": float(s.rng.uniform(0.25, 0.75))}


Amounts = Callable[[Setting], Mapping[str, float]]
AMOUNTS: Mapping[str, Amounts] = {
    "layer_over_core": _layer,
    "exponential_stiffness": lambda s: {"length": s.between(0.8, 1.6) * s.depth / s.size},
    "second_contact": lambda s: {
        "force": 0.3 * s.size * s.force / (1e3 * s.depth),
        "at": s.between(0.4, 0.7) * s.depth,
        "exponent": float(s.rng.choice([1.0, 1.5])),
    },
    "mullins_softening": lambda s: {"loss": 0.15 * s.size, **_width(s)},
    "healing_softening": lambda s: {"loss": 0.15 * s.size, "rate": s.between(5e-3, 0.15), **_width(s)},
    "rate_dependent_friction": lambda s: {
        "kinetic": 1.0 - 0.2 * s.size,
        "growth": 0.03 * s.size,
        "stribeck": 0.5 * s.depth,
        "slow": 0.05 * s.depth,
    },
    "friction_ageing": lambda s: {
        "growth": s.between(0.03, 0.08) * s.size,
        "time": 0.1,
        "distance": s.between(5e-6, 5e-5),
    },
    "presliding": lambda s: {
        "distance": s.between(0.03, 0.2) * s.depth,
        "felt": float(s.rng.uniform(0.3, 0.7)),
        "speed_at_once": float(s.rng.random() < 0.5),
    },
    "load_dependent_friction": lambda s: {"exponent": 0.15 * s.size, "at": 0.4 * s.force},
    "sensor_delay": lambda s: {"time": s.between(4e-3, 12e-3)},
    "sensor_lag": lambda s: {"time": s.between(4e-3, 12e-3)},
    "zero_jump": lambda s: _jump(s, s.between(1.0, 4.0) * s.noise),
    "zero_jump_displacement": lambda s: _jump(s, s.between(0.003, 0.02) * s.depth),
}
"""By the names of the catalogue; and a zero of force or displacement that jumps, which is no effect."""


@dataclass(frozen=True)
class Made:
    """A recording and what is hidden in it."""

    columns: dict[str, Array]
    radius: float
    noise: dict[str, float]
    hidden: dict[str, dict[str, float]]


def make(names: Sequence[str], style: str, seed: int, size: float = 1.0) -> Made:
    """Return the recording of a protocol (``style``) with these laws hidden, all else drawn by the seed."""
    rng = np.random.default_rng([seed, 71])
    tip = draw_tip(rng)
    depth = float(rng.uniform(0.12, 0.2)) * tip.radius
    louder = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    noise = {
        "normal_force": 0.01 * louder, "tangential_force": 0.01 * louder, "torque_z": 1e-4,
        "displacement": 5e-6 * float(np.exp(rng.uniform(np.log(0.4), np.log(1.6)))), "contact_radius": 5e-5,
    }  # fmt: skip
    rate, sees = float(rng.choice([100.0, 200.0])), bool(rng.random() < 0.4)
    episodes = PROTOCOLS[style](tip, depth, rng)
    setting = Setting(tip, depth, noise["normal_force"], size, rng)
    hidden = {name: dict(AMOUNTS[name](setting)) for name in names}
    true = simulate(tip, Laws(hidden), episodes)
    late = {name: hidden.get(f"sensor_{name}", {}).get("time", 0.0) for name in ("delay", "lag")}
    columns = sensed(true, rate, noise, rng, **late, sees=sees)
    for name, channel in (("zero_jump", "normal_force"), ("zero_jump_displacement", "displacement")):
        if jump := hidden.get(name):
            rows = columns["t"].size
            columns[channel] = columns[channel] + jump["size"] * (np.arange(rows) >= jump["when"] * rows)
    return Made(columns, tip.radius, noise, hidden)
