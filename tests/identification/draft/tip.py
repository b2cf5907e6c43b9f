"""A fingertip of its own: power law and one branch of relaxation, with a law hidden in it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

K, P, C1, NU, RADIUS = 2.0, 1.6, 0.3, 2.0, 8e-3
DEPTH = RADIUS / 10.0
NOISE_N, NOISE_M = 0.01, 1e-6
SECOND_BODY_MM = 0.9
STEP_S, EACH = 2.5e-3, 4  # of the simulation, and steps a sample

Law = Callable[[float, float, float, dict[str, float]], tuple[float, float, float]]
"""Of depth [x_ref], speed, elastic force [N], memory: that force, factors on its relaxation and on all."""


def nothing(x: float, speed: float, force: float, memory: dict[str, float]) -> tuple[float, float, float]:
    return force, 1.0, 1.0


def wear(x: float, speed: float, force: float, memory: dict[str, float]) -> tuple[float, float, float]:
    memory["way"] = memory.get("way", 0.0) + (abs(speed) * STEP_S if x > 0.0 else 0.0)
    return force, 1.0, 1.0 - 0.25 * (1.0 - np.exp(-memory["way"] / 4.0))


def quick_when_deep(
    x: float, speed: float, force: float, memory: dict[str, float]
) -> tuple[float, float, float]:
    return force, 1.0 + 1.5 * max(x, 0.0) ** 2, 1.0


def second_body(x: float, speed: float, force: float, memory: dict[str, float]) -> tuple[float, float, float]:
    return force + 1.2 * max(x - SECOND_BODY_MM, 0.0), 1.0, 1.0


def thixotropic(x: float, speed: float, force: float, memory: dict[str, float]) -> tuple[float, float, float]:
    """What moved lately is soft, and hardens under a constant indentation, which no pad does by itself."""
    z = memory.get("moved", 0.0)
    memory["moved"] = z + (abs(speed) - z) * STEP_S / 0.8
    return force, 1.0, 1.0 - 0.2 * (1.0 - np.exp(-memory["moved"]))


def write_presses(law: Law, folder: Path, seed: int = 0, episodes: int = 8) -> None:
    """Write a recording of presses of several depths, speeds and holds."""
    rng = np.random.default_rng(seed)
    memory: dict[str, float] = {}
    rows, begin = [], 0.0
    for episode in range(episodes):
        deep, speed = rng.uniform(0.6, 1.6) * DEPTH, 1e-3 * 10.0 ** rng.uniform(-0.3, 1.0)
        ramp = (deep + 0.2 * DEPTH) / speed
        at = np.cumsum([0.0, 0.4, ramp, rng.uniform(0.5, 4.0), ramp, 0.5])
        t = np.arange(0.0, at[-1], STEP_S)
        x = np.interp(t, at, np.array([-0.2, -0.2, deep / DEPTH, deep / DEPTH, -0.2, -0.2]))
        force, z = np.zeros(t.size), 0.0
        for i in range(1, t.size):
            elastic = K * max(x[i], 0.0) ** P
            elastic, rate, factor = law(x[i], (x[i] - x[i - 1]) / STEP_S, elastic, memory)
            kept = np.exp(-NU * rate * STEP_S)
            z = z * kept + (1.0 - kept) * C1 * elastic
            force[i] = max((elastic - z) * factor, 0.0) if x[i] > 0.0 else 0.0
        seen = slice(None, None, EACH)
        n = t[seen].size
        shown = (
            DEPTH * x[seen] + NOISE_M * rng.standard_normal(n),
            force[seen] + NOISE_N * rng.standard_normal(n),
        )
        rows.append(np.column_stack([begin + t[seen], np.full(n, episode), *shown]))
        begin += at[-1] + 30.0
    folder.mkdir()
    head = "t,episode,displacement,normal_force"
    np.savetxt(folder / "recording.csv", np.vstack(rows), delimiter=",", header=head, comments="", fmt="%.9g")
    sensors = f"[sensors]\nnormal_force = {NOISE_N}\ndisplacement = {NOISE_M}\n"
    (folder / "recording.toml").write_text(f"[fingertip]\nradius = {RADIUS}\n{sensors}")
