"""Lives of fingertips from outside: drawn or chosen parameters, what is told of them, what is measured."""

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from validation.estimator_coverage.drives import Manner, drive
from validation.estimator_coverage.outside import SIMULATION_STEP_S, Contact, Finger, live
from vegrip.clock import NS
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import ContactModel, paper_model

LOST_SHARES = (0.0, 0.01, 0.05)  # of the samples
SLIDING_SPEED = 1e-3  # [m/s]
WIDEST = 2.0  # standard deviations by which a searched prior may be wrong


@dataclass(frozen=True)
class Life:
    """What varies from life to life; errors of the prior and zeros in standard deviations."""

    seed: int
    radius: float  # [m]
    stiffness: float  # [N]
    exponent: float
    share: float
    rate: float  # [1/s]
    friction: float
    sampling: float  # [Hz]
    jitter: float  # of the spacing
    lost: float  # share of the samples
    haste: float
    force: float
    wrong_stiffness: float
    wrong_exponent: float
    wrong_share: float
    wrong_rate: float
    wrong_friction: float
    wrong_k0: float
    wrong_zero: float
    wrong_bias: float

    def __str__(self) -> str:
        """Return all values in one line."""
        return " ".join(f"{field.name}={getattr(self, field.name):.10g}" for field in fields(self))


DIMENSIONS = len(fields(Life)) - 1


def chosen(u: np.ndarray[tuple[int], np.dtype[np.float64]], seed: int) -> Life:
    """Return the life at ``u`` (DIMENSIONS,) in the unit cube; errors within WIDEST."""
    return Life(
        seed,
        3e-3 + 17e-3 * u[0],
        0.3 * 100.0 ** u[1],
        1.2 + u[2],
        0.6 * u[3],
        0.05 * 600.0 ** u[4],
        0.3 * 4.0 ** u[5],
        100.0 * 20.0 ** u[6],
        0.3 * u[7],
        LOST_SHARES[min(int(u[8] * len(LOST_SHARES)), len(LOST_SHARES) - 1)],
        *u[9:11],
        *(WIDEST * (2.0 * u[11:] - 1.0)),
    )


def drawn(rng: np.random.Generator) -> Life:
    """Draw a life; the errors are normal."""
    life = chosen(rng.random(DIMENSIONS), int(rng.integers(2**31)))
    errors = (f.name for f in fields(Life) if f.name.startswith("wrong_"))
    return Life(**{**vars(life), **{name: rng.standard_normal() for name in errors}})


def finger_of(life: Life) -> Finger:
    """Return the true parameters."""
    k0 = 2.0 + 0.05 * life.wrong_k0
    return Finger(life.radius, life.stiffness, life.exponent, life.share, life.rate, life.friction, k0)


def told(life: Life) -> ContactModel:
    """Return the prior of the paper's model about values wrong by its own standard deviations."""
    model = paper_model(life.radius)
    share = min(max(life.share + 0.1 * life.wrong_share, 0.0), 0.9)
    for symbol, value in (
        ("K", life.stiffness * math.exp(0.5 * life.wrong_stiffness)),
        ("p", life.exponent + 0.1 * life.wrong_exponent),
        ("c1", share),
        ("nu1", life.rate * math.exp(0.3 * life.wrong_rate)),
        ("mu", life.friction * math.exp(0.4 * life.wrong_friction)),
    ):
        model = model.with_value(symbol, value)
    return model


def lived(
    style: str, life: Life, noise: SensorNoise, settings: EstimatorSettings
) -> tuple[Contact, list[FingertipState]]:
    """Return the truth at the samples and what the sensors say there."""
    episodes, air = drive(style, finger_of(life), Manner(life.haste, life.force, life.seed))
    truth = live(finger_of(life), episodes, air)
    rng = np.random.default_rng([life.seed, 1])
    places = sampled(truth, life, rng)
    truth = Contact(*(column[places] for column in truth))
    return truth, measured(truth, life, noise, settings, rng)


def sampled(truth: Contact, life: Life, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the places on the grid that are sampled: with jitter, and some lost."""
    spacing = 1.0 / (life.sampling * SIMULATION_STEP_S)
    n = int(truth.t.size / spacing)
    due = (np.arange(n) + life.jitter * rng.uniform(-1.0, 1.0, n)) * spacing
    places = np.unique(np.clip(np.round(due), 0, truth.t.size - 1).astype(np.int64))
    return places[rng.random(places.size) >= life.lost]


def measured(
    truth: Contact, life: Life, noise: SensorNoise, settings: EstimatorSettings, rng: np.random.Generator
) -> list[FingertipState]:
    """Add white noise and constant errors of the zeros."""

    def noisy(column: "np.ndarray[tuple[int], np.dtype[np.float64]]", std: float) -> list[float]:
        return [float(value) for value in column + std * rng.standard_normal(column.size)]

    force = noisy(
        truth.force + settings.force_bias * noise.normal_force * life.wrong_bias, noise.normal_force
    )
    zero = settings.offset * life.radius * life.wrong_zero
    displacement = noisy(truth.depth + zero, noise.displacement)
    x, y = noisy(truth.tangential, noise.tangential_force), noisy(0.0 * truth.t, noise.tangential_force)
    torque = noisy(truth.torque, noise.torque_z)
    slips = (truth.used >= 1.0).astype(float).tolist()
    stamps = np.round(truth.t * NS).astype(np.int64).tolist()
    rows = zip(stamps, force, x, y, torque, displacement, slips, strict=True)
    return [
        FingertipState(t, "tip", i, N, fx, fy, m, d, slip=s, slip_speed=SLIDING_SPEED * s)
        for i, (t, N, fx, fy, m, d, s) in enumerate(rows)
    ]
