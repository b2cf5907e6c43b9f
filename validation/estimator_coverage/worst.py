"""Search the life on which the estimator's interval is worst: random draws, then local steps."""

from dataclasses import dataclass

import numpy as np

from validation.estimator_coverage.lives import DIMENSIONS, chosen
from validation.estimator_coverage.style_table import Result, judge

RANDOM = 0.4  # share of the tries that are drawn anew
LONGEST, SHORTEST = 0.3, 0.05  # of a local step in the unit cube
MOVED = 0.3  # share of the coordinates that a local step moves


@dataclass(frozen=True)
class Worst:
    """The worst life found in a style, and after how many tries."""

    style: str
    result: Result
    tries: int


def badness(result: Result) -> float:
    """Rate a life: contacts lost, looks far off or not valid, and the largest error."""
    looks = max(len(result.errors), 1)
    return result.lost + 10.0 * (result.far + result.not_valid / looks) + 0.01 * min(result.worst, 100.0)


def search(style: str, tries: int, seed: int) -> Worst:
    """Return the worst of ``tries`` lives."""
    rng = np.random.default_rng([seed, tries, sum(style.encode())])
    best: Result | None = None
    centre, drive = rng.random(DIMENSIONS), 0
    for number in range(tries):
        progress = number / tries
        if best is None or progress < RANDOM:
            u, seed_of_drive = rng.random(DIMENSIONS), int(rng.integers(2**31))
        else:
            step = LONGEST * (SHORTEST / LONGEST) ** progress * rng.standard_normal(DIMENSIONS)
            u = np.clip(centre + step * (rng.random(DIMENSIONS) < MOVED), 0.0, 1.0)
            seed_of_drive = drive
        result = judge(style, chosen(u, seed_of_drive))
        if best is None or badness(result) > badness(best):
            best, centre, drive = result, u, seed_of_drive
    if best is None:
        message = "a search needs at least one try"
        raise ValueError(message)
    return Worst(style, best, tries)


def describe(worst: Worst) -> str:
    """Return the worst life and what happened in it."""
    r = worst.result
    when = ", ".join(f"{t:.2f}" for t in r.started[:5]) or "-"
    return (
        f"{worst.style}: worst of {worst.tries} lives: error {r.worst:.1f} std at {r.worst_at:.2f} s, "
        f"{100 * r.far:.2f} % of looks beyond 6 std, {r.not_valid} of {len(r.errors)} looks not valid, "
        f"{r.lost} contacts lost (at {when} s)\n  {r.life}"
    )
