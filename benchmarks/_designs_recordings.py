"""Recordings with the truth beside them: from a folder, or drawn here by a direct integration."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vegrip.types import Floats

FINE = 2.5e-4  # [s] of the integration of drawn recordings
RATE = 200.0  # [Hz] of their samples


@dataclass(frozen=True)
class Truthful:
    """What the sensors said, (n,) each, and what was true."""

    name: str
    tip_radius: float  # [m]
    noise: Floats  # standard deviation: displacement [m], force [N]
    t: Floats  # [s]
    displacement: Floats  # [m]
    normal_force: Floats  # [N]
    indentation: Floats  # [m], true
    true_force: Floats  # [N]
    parameters: Floats  # true ln K, p, c1, ln nu


def loaded(folder: Path) -> Truthful:
    """Read ``recording.csv.gz``, ``truth.csv.gz`` and both settings files of one folder."""
    said = np.genfromtxt(folder / "recording.csv.gz", delimiter=",", names=True)
    true = np.genfromtxt(folder / "truth.csv.gz", delimiter=",", names=True)
    told = tomllib.loads((folder / "recording.toml").read_text(encoding="utf-8"))
    hidden = tomllib.loads((folder / "truth.toml").read_text(encoding="utf-8"))
    sensors = told["sensors"]
    logarithms = math.log(hidden["force_at_tenth_radius"]), math.log(hidden["nu1"])
    return Truthful(
        folder.name,
        told["fingertip"]["radius"],
        np.array([sensors["displacement"], sensors["normal_force"]]),
        said["t"].copy(),
        said["displacement"].copy(),
        said["normal_force"].copy(),
        true["displacement"].copy(),
        true["normal_force"].copy(),
        np.array([logarithms[0], hidden["exponent"], hidden["c1"], logarithms[1]]),
    )


def drawn(seed: int, *, presses: int = 5) -> Truthful:
    """Draw a fingertip within its prior, and presses at two speeds with holds, a swell and a release each."""
    rng = np.random.default_rng(seed)
    R = rng.uniform(5e-3, 15e-3)
    guess = math.log(4.0 / 3.0 * 3e5 * math.sqrt(R) * (R / 10.0) ** 1.5)
    widths = np.array([0.5, 0.1, 0.07, 0.3])
    true = np.array([guess, 1.5, 0.3, math.log(3.1)]) + widths * rng.standard_normal(4)
    true[2] = min(max(true[2], 0.05), 0.6)
    knots, depths = motion(rng, R, presses)
    fine = np.arange(0.0, knots[-1], FINE)
    x = np.interp(fine, knots, depths)
    N = pressed(fine, x, true, R / 10.0)
    every = slice(0, None, round(1.0 / RATE / FINE))
    noise = np.array([5e-6, 0.01])
    t, x, N = fine[every], x[every], N[every]
    d = x + noise[0] * rng.standard_normal(t.size)
    F = N + noise[1] * rng.standard_normal(t.size)
    return Truthful(f"drawn-{seed}", R, noise, t, d, F, x, N, true)


def motion(rng: np.random.Generator, R: float, presses: int) -> tuple[Floats, Floats]:
    """Return knots [s] and indentations [m] there: air, ramp, hold, deeper, hold, back, out."""
    air = -0.02 * R
    knots, depths = [0.0, 0.2], [air, air]
    for _ in range(presses):
        deep, swell = R * rng.uniform(0.05, 0.12, 2)
        times = [rng.choice([0.05, 0.3]), rng.uniform(0.4, 1.0), 0.1, 0.4, rng.uniform(0.1, 0.4), 0.3]
        knots += list(knots[-1] + np.cumsum(times))
        depths += [deep, deep, swell, swell, air, air]
    return np.array(knots), np.array(depths)


def pressed(t: Floats, x: Floats, true: Floats, depth: float) -> Floats:
    """Integrate ``dz/dt = nu (N_e - z)``, ``N = max(N_e - c z, 0)``, step by step; return N [N].

    A surface that is not touched has the elastic force ``c z``.
    """
    K, p, c, nu = math.exp(true[0]), true[1], true[2], math.exp(true[3])
    elastic = K * (np.maximum(x, 0.0) / depth) ** p
    N, z = np.zeros(t.size), 0.0
    keep = math.exp(-nu * FINE)
    for i in range(1, t.size):
        felt = 0.5 * (max(elastic[i - 1], c * z) + max(elastic[i], c * z))
        z = felt + keep * (z - felt)
        N[i] = max(elastic[i] - c * z, 0.0)
    return N
