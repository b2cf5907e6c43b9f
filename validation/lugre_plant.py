"""Objects between two fingers whose faces follow the LuGre law, with drives that have play and late samples.

A world that is not ours, under the controller of the node. For each contact, per unit of normal force, with
the bristle z and the velocity v in (x, y, torsion at the effective radius)::

    z' = v - s0 |v| z / g(v),     g(v) = kinetic mu + (1 - kinetic) mu exp(-(|v| / STRIBECK)^2)
    f  = s0 z + s1 z' + s2 v,     mu = mu_5 (N / 5 N)^-exponent                       [CanudasDeWitEtAl1995]_

so a contact creeps before it slides, breaks away above its kinetic friction, and drifts under a load that
shakes. Friction and exponent are drawn from what is published (:mod:`vegrip.trials.published_friction`), the
rest from stated ranges, none from a belief. A drive follows its command with one pole, a limit of rate and
play: it gives way only when the command has turned back by that much.

``python -m validation.lugre_plant --seeds 20 --controller learning``; exit code 1 where an object is lost.
"""

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from validation.held_object import NEVER_S, Filling, Held, Outcome, run, sentence, summed, two_pushes
from vegrip.hand_sample import HandSample
from vegrip.trials.candidates import KNOBS
from vegrip.trials.published_friction import TANGENTIAL_GAIN_RANGE, draw_friction
from vegrip.types import Floats
from vegrip.virtual import Disturbance, HandSettings, kernels
from vegrip.virtual.disturbance import Wetting, burden_rows
from vegrip.virtual.kernels import Records
from vegrip.virtual.sensor import Sensors

STEP_S = 1e-4
TORSION = 0.6  # limit torque over mu N a
STRIBECK_M_S = 2e-3
STATED_AT_N = 5.0  # normal force at which friction is the one that is stated
WHOLE = 0.99  # share of its motion that is lost to the bristles, from which on a contact slides as a whole
LEAST_PRESSED_N = 0.05  # below it friction rises no more
DAMPED = 0.4  # s1 over what damps the object critically
JITTER_S, DROPOUT = 5e-4, 0.01  # of the samples

PULL_X, PULL_Y, PULL_TURN, PLASTIC, SPEED = range(5)  # of a contact, after its step


@dataclass(frozen=True)
class Faces:
    """What the two contacts and the drive are made of."""

    friction: tuple[float, float]  # at 5 N, of each finger
    exponent: float
    kinetic: float  # share of friction that is left at speed
    presliding: float  # [m] s0 is friction over it
    play: float  # [N]
    viscous: float  # [s/m] s2


def draw_faces(rng: np.random.Generator, friction: float, exponent: float) -> Faces:
    """Draw a make; the two fingers have 8 % scatter."""
    first, second = friction * np.exp(0.08 * rng.standard_normal(2))
    return Faces(
        friction=(float(first), float(second)),
        exponent=exponent,
        kinetic=float(rng.uniform(0.75, 1.0)),
        presliding=float(np.exp(rng.uniform(math.log(5e-5), math.log(4e-4)))),
        play=float(rng.uniform(0.0, 0.4)),
        viscous=float(rng.uniform(0.0, 0.5)),
    )


TARGET, FOLLOWED, FORCE = range(3)  # [N] of the drive


@njit(cache=True)
def step_faces(body: Floats, bristles: Floats, made: Floats, felt: Floats, load: Floats, inertia: Floats,
               force: float) -> None:  # fmt: skip
    """Advance object and bristles by :data:`STEP_S` in place.

    ``body`` holds x, y, angle and their speeds; of each contact ``made`` holds mu, kinetic, s0, s1, s2 and
    effective radius, ``felt`` the numbers of PULL_X and so on; ``inertia`` mass and moment.
    """
    total, v = load.copy(), np.empty(3)
    for i in range(2):
        mu, kinetic, s0, s1, s2, radius = made[i]
        v[0], v[1], v[2] = body[3], body[4], body[5] * radius
        speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        g = mu * (kinetic + (1.0 - kinetic) * math.exp(-((speed / STRIBECK_M_S) ** 2)))
        lost, stretch = s0 * speed / g, 0.0
        for k in range(3):
            before = bristles[i, k]
            bristles[i, k] = (before + STEP_S * v[k]) / (1.0 + STEP_S * lost)
            rate = (bristles[i, k] - before) / STEP_S
            felt[i, k] = force * (s0 * bristles[i, k] + s1 * rate + s2 * v[k])
            stretch += bristles[i, k] ** 2
        felt[i, PULL_TURN] *= radius
        felt[i, PLASTIC] = lost * math.sqrt(stretch)
        felt[i, SPEED] = speed
        total -= felt[i, :3]
    for k in range(3):
        body[3 + k] += STEP_S * total[k] / inertia[min(k // 2, 1)]
        body[k] += STEP_S * body[3 + k]


@njit(cache=True)
def follow_drive(drive: Floats, limits: Floats, wanted: float) -> float:
    """Follow the commanded force with a limit of rate, one pole and play; NaN holds what is pressed."""
    limit, rate, pole, half = limits
    if not math.isnan(wanted):
        most = rate * STEP_S
        drive[TARGET] += min(max(min(max(wanted, 0.0), limit) - drive[TARGET], -most), most)
    drive[FOLLOWED] += pole * STEP_S * (drive[TARGET] - drive[FOLLOWED])
    low, high = drive[FOLLOWED] - half, drive[FOLLOWED] + half
    drive[FORCE] = max(min(max(drive[FORCE], low), high), 0.0)
    return float(drive[FORCE])


@njit(cache=True)
def weigh_object(held: Floats, burden: Floats, angle: float, now: float) -> tuple[Floats, Floats]:
    """Return load (force x and y [N], torque [N m]) and inertia of the object, lifted since ``close`` [s]."""
    mass, inertia, offset_x, offset_y, gravity, close, lift, _ = held
    mass += burden[3]
    weight = min(max((now - close) / lift, 0.0), 1.0) * mass * gravity
    down_x, down_y = weight * math.sin(burden[4]), -weight * math.cos(burden[4])
    arm_x = offset_x * math.cos(angle) - offset_y * math.sin(angle)
    arm_y = offset_x * math.sin(angle) + offset_y * math.cos(angle)
    turn = burden[2] + arm_x * down_y - arm_y * down_x
    load = np.array([burden[0] + down_x, burden[1] + down_y, turn])
    return load, np.array([mass, inertia + mass * (arm_x**2 + arm_y**2)])


@njit(cache=True)
def make_faces(tips: Records, makes: Floats, made: Floats, held: Floats, wet: float, force: float) -> None:
    """Write what :func:`step_faces` takes of each contact at a normal ``force``, and the tips' contact."""
    pressed = max(force, LEAST_PRESSED_N)
    for i in range(2):
        mu5, exponent, kinetic, presliding, viscous, radius, d0, relaxed, p = makes[i]
        tips[i].force, tips[i].depth = force, d0 * (force / relaxed) ** (1.0 / p)
        tips[i].a = math.sqrt(radius * max(tips[i].depth, 1e-9))
        tips[i].mu = wet * mu5 * (pressed / STATED_AT_N) ** -exponent
        s0 = tips[i].mu / presliding
        made[i, 0], made[i, 1], made[i, 2] = tips[i].mu, kinetic, s0
        made[i, 3] = DAMPED * math.sqrt(held[0] * s0 * pressed) / pressed
        made[i, 4], made[i, 5] = viscous, TORSION * tips[i].a


@njit(cache=True)
def advance_hand(tips: Records, body: Floats, bristles: Floats, drive: Floats,
                 makes: Floats, limits: Floats, held: Floats, command: float, burdens: Floats,
                 tick: int) -> None:  # fmt: skip
    """Advance the whole hand by as many steps as there are ``burdens``, after step number ``tick``."""
    made, felt = np.empty((2, 6)), np.zeros((2, 5))
    for step in range(len(burdens)):
        now = (tick + step + 1) * STEP_S
        force = follow_drive(drive, limits, held[7] if now <= held[5] else command)
        make_faces(tips, makes, made, held, burdens[step, 5], force)
        load, inertia = weigh_object(held, burdens[step], body[2], now)
        step_faces(body, bristles, made, felt, load, inertia, force)
        for i in range(2):
            tips[i].pull_x, tips[i].pull_y = felt[i, PULL_X], felt[i, PULL_Y]
            tips[i].torque, tips[i].slip_speed = felt[i, PULL_TURN], felt[i, PLASTIC]
            tips[i].sliding_share = 1.0 if felt[i, PLASTIC] > WHOLE * felt[i, SPEED] else 0.0
            if tips[i].sliding_share > 0.0:
                tips[i].slip_distance += tips[i].slip_speed * STEP_S


class LugreHand:
    """A plant as :class:`vegrip.trials.known_contact.Plant` has it, of two fingers."""

    def __init__(
        self, settings: HandSettings, faces: Faces, seed: int, events: Sequence[Disturbance] = ()
    ) -> None:
        self.settings, self.fingers, self._faces, self._events = settings, settings.fingers, faces, events
        make, noise = (np.random.default_rng([seed, stream]) for stream in (0, 1))
        self._sensors = Sensors(settings.sensor, settings.fingers, noise)
        self._records, self._summary = np.zeros(2, kernels.TIP), np.zeros(1, kernels.BODY)
        self._records["side"], self._records["k"] = (1.0, -1.0), 2.0
        self._body, self._bristles, self._drive = np.zeros(6), np.zeros((2, 3)), np.zeros(3)
        self._makes = np.array([
            [mu, faces.exponent, faces.kinetic, faces.presliding, faces.viscous, tip.radius,
             tip.reference_indentation, (1.0 - sum(tip.amplitudes)) * tip.reference_force, tip.exponent]
            for mu, tip in zip(faces.friction, settings.tips(make), strict=True)
        ])  # fmt: skip
        a, p = settings.actuator, settings.plate
        pole = 2.0 * math.pi * a.bandwidth
        self._limits = np.array([a.force_limit, a.force_rate, pole, 0.5 * faces.play])
        self._held = np.array([
            p.mass, p.inertia, p.offset_x, p.offset_y, p.gravity, a.close_time, a.lift_time, a.initial_force,
        ])  # fmt: skip
        self._ticks = self._samples = 0
        self._asked = 0.0

    @property
    def time(self) -> float:
        return self._ticks * STEP_S

    @property
    def slips(self) -> int:
        return int(self._summary["slips"][0])

    @property
    def largest_micro_slip(self) -> float:
        return float(self._summary["largest_micro_slip"][0])

    @property
    def friction_exponent(self) -> float:
        return self._faces.exponent

    @property
    def shift(self) -> float:
        """How far the object has moved along the faces since the start [m]."""
        return math.hypot(self._body[0], self._body[1])

    @property
    def dropped(self) -> bool:
        plate = self.settings.plate
        return self.shift > plate.drop_distance or abs(self._body[2]) > plate.drop_angle

    def contact(self, number: int) -> tuple[float, float, float, float]:
        tip = self._records[number]
        return float(tip["force"]), float(tip["mu"]), float(tip["a"]), float(tip["k"])

    def advance(self, dt: float, commands: Floats) -> list[HandSample]:
        samples: list[HandSample] = []
        self._asked += dt
        command = float(np.nanmax(commands)) if np.isfinite(commands).any() else math.nan
        every = round(1.0 / (self.settings.sensor.rate * STEP_S))
        while steps := min(round(self._asked / STEP_S), (self._samples + 1) * every) - self._ticks:
            times = np.arange(self._ticks + 1, self._ticks + steps + 1, dtype=np.float64) * STEP_S
            burdens = burden_rows(self._events, times)
            advance_hand(
                self._records, self._body, self._bristles, self._drive, self._makes,
                self._limits, self._held, command, burdens, self._ticks,
            )  # fmt: skip
            self._ticks += steps
            self._summary["step"] = steps * STEP_S
            kernels.watch_slips(self._summary[0], self._records)
            if self._ticks == (self._samples + 1) * every:
                self._samples += 1
                samples.append(self._sensors.sample(self._records, self.settings.thermal.start, self.time))
        return samples

    def truths(self) -> Floats:
        rows = []
        for tip in self._records:
            s, load = tip["side"], math.hypot(tip["pull_x"], tip["pull_y"])
            felt = math.hypot(load, tip["torque"] / (TORSION * tip["a"])) if tip["a"] > 0.0 else 0.0
            used = felt / (tip["mu"] * tip["force"]) if tip["force"] > 0.0 else 0.0
            radius = math.hypot(load, tip["torque"] / tip["a"]) / used if used > 0.0 else math.inf
            at = (tip["force"], tip["depth"], tip["a"], tip["k"], tip["mu"])
            pulls = (-s * tip["pull_x"], tip["pull_y"], -s * tip["torque"])
            slides = (tip["slides"], tip["sliding_share"], tip["slip_speed"], tip["slip_distance"])
            rows.append([*map(float, (*at, *pulls, used, radius, *slides))])
        return np.array(rows)


def least_force(
    force: float,
    tangential: float,
    torque: float,
    mu: float,
    radius: float,
    exponent: float,  # noqa: ARG001 (an ellipse has none)
    friction_exponent: float = 0.0,
) -> float:
    """Return the normal force [N] at which a load breaks away; a ``known_contact.LeastForce``."""
    if not (force > 0.0 and radius > 0.0):
        return 0.0 if tangential + torque == 0.0 else math.inf
    plain = math.hypot(tangential, torque / (TORSION * radius)) / mu
    least: float = force * (plain / force) ** (1.0 / (1.0 - friction_exponent))
    return least


FILLED, WET = Filling(3.0, NEVER_S, 0.25, 3.0), Wetting(4.0, 5.0, 0.6)
OBJECTS: Mapping[str, Held] = {
    "sheet": Held("250 g, 15 mm off its centre", 0.25, 0.6, offset_x=0.015, bears=30.0),
    "block": Held("200 g, pushed twice", 0.2, 0.6, offset_y=0.0, bears=30.0, events=two_pushes()),
    "mug": Held("300 g, filled with 250 g in 3 s", 0.3, 0.6, bears=30.0, events=(FILLED,)),
    "tin": Held("400 g, wet from 4 s: 0.6 of the friction", 0.4, 0.6, bears=30.0, events=(WET,)),
}


def hold(name: str, controller: str, seed: int) -> Outcome:
    """Hold one of :data:`OBJECTS` between faces that are drawn."""
    held, rng = OBJECTS[name], np.random.default_rng([seed, 7])
    _, mu, exponent = draw_friction(rng)
    faces, settings = draw_faces(rng, mu, exponent), held.settings()
    gain = float(rng.uniform(*TANGENTIAL_GAIN_RANGE))
    sensor = replace(settings.sensor, tangential_gain=gain, jitter=JITTER_S, dropout=DROPOUT)
    bandwidth = float(np.exp(rng.uniform(math.log(5.0), math.log(20.0))))
    drive = replace(settings.actuator, bandwidth=bandwidth, force_limit=held.bears)
    hand = LugreHand(replace(settings, sensor=sensor, actuator=drive), faces, seed, held.events)
    return run(hand, controller, mu, held.bears, least_force)


def main() -> int:
    """Print a row for every object; return 1 where one is lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--only", choices=OBJECTS, nargs="*", default=list(OBJECTS))
    parser.add_argument("--controller", default="vegrip", choices=tuple(KNOBS["pinch"]))
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    figures = {}
    for name in chosen.only:
        seeds = range(chosen.first_seed, chosen.first_seed + chosen.seeds)
        figures[name] = summed([hold(name, chosen.controller, seed) for seed in seeds])
        if not chosen.json:
            print(f"{name:6} {OBJECTS[name].about}: {sentence(figures[name])}", flush=True)
    if chosen.json:
        print(json.dumps(figures))
    return int(any(one["drops"] for one in figures.values()))


if __name__ == "__main__":
    sys.exit(main())
