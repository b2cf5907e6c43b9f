"""Truths that share no code with the estimator: fingertips of the virtual hand, history summed directly.

The estimator is told what a calibration would tell: radius, and the other parameters wrong by as much as
their standard deviations say.
"""

import math

import numpy as np

from validation.estimator_coverage.truth import Truth, motion, scattered, sensed
from vegrip.contact.limit_surface.reference import radius
from vegrip.effects import effect
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.model import ContactModel, Simulation, paper_model
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.settings import FingertipSettings, random_fingertip

SIMULATION_STEP_S = 2e-3  # [s]


def live_independently(
    noise: SensorNoise, settings: EstimatorSettings, rng: np.random.Generator, *, duration: float = 12.0
) -> tuple[ContactModel, Truth]:
    """Draw a fingertip, let it live; return what the estimator is told of it, and the truth."""
    tip = random_fingertip(rng)
    t = np.arange(1.0, duration / SIMULATION_STEP_S) * SIMULATION_STEP_S
    delta, share, number = motion(t, tip.radius, rng, start_in_contact=False)
    contact, friction = pressed(tip, delta), scattered(number, settings, rng)
    tangential, torque, used, slip = loading(contact, share, friction, rng)
    model = told(tip, rng)
    record = Truth(model, t, delta, contact, tangential, torque, used, [], friction)
    record.states.extend(sensed(record, slip, noise, settings, rng))
    return model, record


def pressed(tip: FingertipSettings, delta: np.ndarray) -> Simulation:
    """Impose the indentations on the virtual fingertip."""
    soft = Fingertips([tip], SIMULATION_STEP_S)
    rows = []
    for depth in delta:
        N = float(soft.press(np.array([depth]))[0])
        rows.append((depth, 0.0, N, N, soft.contact_radius[0], soft.pressure_exponent[0], tip.friction))
    return Simulation(*np.array(rows, dtype=np.float64).T)


def loading(
    contact: Simulation, share: np.ndarray, friction: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Load by its share of the limit, the limit by quadrature: force, torque, utilisation, slip flag."""
    psi = rng.uniform(0.0, 1.2)
    k = np.clip(contact.pressure_exponent, 1.0, 180.0)
    knots = np.geomspace(1.0, 180.0, 120)
    reach = np.interp(k, knots, radius(knots, np.full(knots.size, psi)))
    limit = friction * contact.friction_coefficient * contact.normal_force * reach
    used = np.minimum(share, 1.0)
    touching = contact.normal_force > 0.0
    torque = used * limit * contact.contact_radius * math.sin(psi)
    slip = ((share >= 1.0) & touching).astype(float)
    return used * limit * math.cos(psi), torque, np.where(touching, used, np.nan), slip


def told(tip: FingertipSettings, rng: np.random.Generator) -> ContactModel:
    """Return the model after a calibration of ordinary quality: ln K 0.2, p 0.05, c 0.05, ln nu 0.3."""
    model = paper_model(tip.radius)
    branches = sorted(zip(tip.rates, tip.amplitudes, strict=True), reverse=True)
    if len(branches) == 2:
        model = model.with_effect(effect("second_relaxation"))
    K = tip.reference_force * (model.reference_depth / tip.reference_indentation) ** tip.exponent
    model = model.with_value("K", K * math.exp(0.2 * rng.standard_normal()), std=0.2)
    model = model.with_value("p", tip.exponent + 0.05 * rng.standard_normal(), std=0.05)
    for i, (nu, c) in enumerate(branches, start=1):
        model = model.with_value(f"c{i}", min(max(c + 0.05 * rng.standard_normal(), 0.02), 0.6), std=0.05)
        model = model.with_value(f"nu{i}", nu * math.exp(0.3 * rng.standard_normal()), std=0.3)
    model = model.with_value("k0", 2.0, std=0.01)
    return model.with_value("mu", 0.7, std=0.4)
