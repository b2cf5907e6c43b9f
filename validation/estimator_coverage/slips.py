"""Grips of virtual fingertips that are held until they slip, or do not: what was forecast, and what came.

The fingertip relaxes by the sum over its history, its limit is searched on the elements of its patch, the
drive behind it may give way; nothing of that is the estimator's. In one life it is pressed and slips once, so
that friction has been felt; it is pressed deeper and loaded by a share of what the felt friction would carry.
Friction scatters about its mean from one slip to the next. Then it is held. The load is drawn
from what could be known, not from when it shall slip: else the forecast would be judged on the unlucky only.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from validation.estimator_coverage.independent import told
from validation.estimator_coverage.truth import Truth, sensed
from vegrip.estimator.estimator import ContactEstimator
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.model import Simulation
from vegrip.types import Floats
from vegrip.virtual.fingertip import Fingertips, even_grid, utilisation
from vegrip.virtual.settings import FingertipSettings, random_fingertip

SIMULATION_STEP_S = 2e-3  # [s]
GRID = even_grid(16, 32)  # its limit surface is good to 1e-3
FIRST_SLIP_S, REGRASP_S, HELD_FROM_S = (
    1.2,
    1.8,
    2.2,
)  # [s] first slip; pressed deeper; loaded, and held from now on
LOOK_SAMPLES = 5  # samples between two looks of the truth at radius and exponent, which change slowly
FRICTION_SCATTER = EstimatorSettings().friction_scatter
LONG = 20.0  # [s] of the hold: what has not slipped then counts as never
LOOKS = (0.1, 1.0)  # [s] into the hold, when the forecast is asked


class Scenario(NamedTuple):
    """What leads to slip."""

    name: str
    stiffness: float = math.inf  # of the drive, in units of reference force over reference indentation
    growing: bool = False  # the load grows evenly, to the double in 2 to 20 s


SCENARIOS = (
    Scenario("position held"),
    Scenario("drive gives way", stiffness=2.0),
    Scenario("load grows", growing=True),
)


class Forecast(NamedTuple):
    """One look; seconds from the look on."""

    estimate: float
    earliest: float
    slip: float  # when it slipped; inf = not within LONG
    slip_if_held: float  # when it would have, had the load stayed as it was


@dataclass(frozen=True)
class Life:
    """A fingertip's life; arrays (n,) over times ``t`` [s], spaced by STEP."""

    t: Floats
    contact: Simulation
    tangential: Floats  # [N]
    torque: Floats  # [N m]
    drive: float  # [N/m]

    def used(self, i: int, load_from: int) -> float:
        """Utilisation at sample ``i`` under the load of sample ``load_from``."""
        return used_by(self.contact, i, self.tangential[load_from], self.torque[load_from])

    def slips_after(self, i: int, *, load_stays: bool) -> float:
        """Time [s] from sample ``i`` to slip; scanned coarsely, then halved."""
        knots = np.unique(np.append(i + np.round(np.geomspace(1, self.t.size - 1 - i, 40)), i)).astype(int)

        def over(j: int) -> bool:
            return self.used(j, i if load_stays else j) >= 1.0

        first = next((place for place, knot in enumerate(knots) if over(knot)), None)
        if first is None:
            return math.inf
        low, high = knots[max(first - 1, 0)], knots[first]
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if over(middle) else (middle, high)
        return float(self.t[high] - self.t[i])


def forecasts(
    scenario: Scenario, slips: int, seed: int, *, branches: int | None = None
) -> Iterator[tuple[int, Forecast]]:
    """Yield (number of the look, forecast) of grips until ``slips`` of them have slipped.

    ``branches`` limits how many relaxation times the estimator is told of; a fingertip has one or two.
    """
    index = 0
    while slips > 0:
        rng = np.random.default_rng([seed, index])
        index += 1
        tip = random_fingertip(rng)
        life = lived(scenario, tip, rng)
        held = sample(HELD_FROM_S)
        if life.used(held, held) >= 1.0:
            continue  # it never came to a hold
        slips -= life.slips_after(held, load_stays=False) < math.inf
        yield from looks(life, tip, rng, branches)


def looks(
    life: Life, tip: FingertipSettings, rng: np.random.Generator, branches: int | None
) -> Iterator[tuple[int, Forecast]]:
    """Run the estimator through a life and ask it at every look before the slip."""
    noise = SensorNoise()
    mixed = life.drive < math.inf
    settings = EstimatorSettings(hold="mixed" if mixed else "position")
    settings = replace(settings, hold_stiffness=life.drive) if mixed else settings
    model = told(knows(tip, branches), rng)
    estimator = ContactEstimator(model, noise, settings)
    due = {sample(HELD_FROM_S + after): number for number, after in enumerate(LOOKS)}
    last = max(due) + 1
    part = Simulation(*(column[:last] for column in life.contact))
    sliding = ((life.t > FIRST_SLIP_S) & (life.t <= FIRST_SLIP_S + 0.02)).astype(float)[:last]
    load = life.tangential[:last], life.torque[:last]
    one = np.ones(last)  # the friction of the life has its scatter already
    truth = Truth(model, life.t[:last], part.indentation, part, *load, sliding, [], one)
    for i, state in enumerate(sensed(truth, sliding, noise, settings, rng)):
        estimator.assimilate(state)
        if i in due:
            slip = life.slips_after(i, load_stays=False)
            if life.used(i, i) >= 1.0 or (i > sample(HELD_FROM_S) and slipped_before(life, i)):
                return
            margin = estimator.slip_margin()
            if_held = life.slips_after(i, load_stays=True)
            yield due[i], Forecast(margin.time_to_slip, margin.earliest_slip, slip, if_held)


def slipped_before(life: Life, i: int) -> bool:
    """Whether the hold ended before sample ``i``."""
    held = sample(HELD_FROM_S)
    return bool(life.slips_after(held, load_stays=False) <= life.t[i] - life.t[held])


def sample(time: float) -> int:
    """Return the index of the sample at ``time`` [s]."""
    return round(time / SIMULATION_STEP_S) - 1


def knows(tip: FingertipSettings, branches: int | None) -> FingertipSettings:
    """Return what a calibration with so many relaxation times would find of ``tip``: the strongest."""
    if branches is None or branches >= len(tip.rates):
        return tip
    kept = sorted(zip(tip.amplitudes, tip.rates, strict=True), reverse=True)[:branches]
    amplitudes, rates = zip(*kept, strict=True)
    return replace(tip, amplitudes=amplitudes, rates=rates)


def lived(scenario: Scenario, tip: FingertipSettings, rng: np.random.Generator) -> Life:
    """Draw a life of ``tip``."""
    t = np.arange(1.0, (HELD_FROM_S + LONG) / SIMULATION_STEP_S) * SIMULATION_STEP_S
    R = tip.radius
    light, firm = rng.uniform(0.04, 0.1) * R, rng.uniform(0.11, 0.16) * R
    depth = np.interp(t, [0.2, 0.5, REGRASP_S - 0.2, REGRASP_S], [-0.02 * R, light, light, firm])
    drive = scenario.stiffness * tip.reference_force / tip.reference_indentation
    before, after = FRICTION_SCATTER * rng.standard_normal(2)
    friction = tip.friction * np.exp(np.where(t < REGRASP_S, before, after))
    contact = pressed(tip, t, depth, drive, friction)
    psi, share, double = rng.uniform(0.0, 1.2), rng.uniform(0.65, 1.0), rng.uniform(2.0, 20.0)
    share = 0.6 * share if scenario.growing else share
    held, felt = sample(HELD_FROM_S), sample(FIRST_SLIP_S)
    unit = math.cos(psi), math.sin(psi) * float(contact.contact_radius[held])
    known = friction[felt] / friction[held]  # what the felt friction would carry
    load = np.array(unit) * share * known / used_by(contact, held, *unit)
    size = np.interp(t, [REGRASP_S, HELD_FROM_S], [0.0, 1.0])
    size *= 1.0 + scenario.growing * np.maximum(t - HELD_FROM_S, 0.0) / double
    first = np.interp(
        t, [FIRST_SLIP_S - 0.5, FIRST_SLIP_S, FIRST_SLIP_S + 0.02, FIRST_SLIP_S + 0.1], [0.0, 1.0, 1.0, 0.0]
    )
    size += first / used_by(contact, felt, *load)
    return Life(t, contact, size * load[0], size * load[1], drive)


def pressed(tip: FingertipSettings, t: Floats, depth: Floats, drive: float, friction: Floats) -> Simulation:
    """Impose the indentations; from HELD on, the ``drive`` [N/m] stands still and gives way."""
    soft = Fingertips([tip], SIMULATION_STEP_S)
    rows, fresh = [], 0.0
    for i, (now, imposed) in enumerate(zip(t, depth, strict=True)):
        given = float(imposed)
        if now > HELD_FROM_S and drive < math.inf:
            given = standing(soft, given, fresh, drive)
        N = float(soft.press(np.array([given]))[0])
        fresh = fresh if now > HELD_FROM_S else N
        if i % LOOK_SAMPLES == 0:
            a, k = float(soft.contact_radius[0]), float(soft.pressure_exponent[0])
        rows.append((given, 0.0, N, N, a, k))
    return Simulation._make([*np.array(rows, dtype=np.float64).T, friction])


def standing(soft: Fingertips, origin: float, fresh: float, drive: float) -> float:
    """Indentation [m] at which the tip balances the drive, ``N + k_d delta = const``, by Newton's method."""
    names = ("past", "instant", "before", "p", "depth", "F0", "d0")
    past, instant, before, p, delta, F0, d0 = (float(soft.records[name][0]) for name in names)
    for _ in range(3):
        elastic = F0 * (delta / d0) ** p
        left = past + instant * (elastic - before) + drive * (delta - origin) - fresh
        delta -= left / (instant * p * elastic / delta + drive)
    return delta


def used_by(contact: Simulation, i: int, force: float, torque: float) -> float:
    """Utilisation of a load at sample ``i``, searched on the elements of the patch."""
    limit = float(contact.friction_coefficient[i] * contact.normal_force[i])
    a, k = float(contact.contact_radius[i]), float(contact.pressure_exponent[i])
    return utilisation(GRID, k, force / limit, torque / (limit * a))
