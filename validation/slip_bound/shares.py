"""How often the truth lies below a bound: shares of grasps, and how many a stated confidence allows."""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from scipy.stats import binom

from validation.slip_bound.forced import STATED, Look
from validation.slip_bound.hand import CONFIDENCES

CHANCE: Final = 0.95
"""With which a bound that holds as stated passes."""


def is_missed(look: Look, confidence: float) -> bool:
    """Return whether the true margin lies below the bound; without a bound, nothing is stated."""
    return look.margin < look.bounds[confidence]


def figures(grasps: Sequence[Sequence[Look]]) -> dict[str, Any]:
    """Return the figures of some grasps, each given by its looks."""
    looks = [look for grasp in grasps for look in grasp]
    slack = [look.margin - look.bounds[STATED] for look in looks if not math.isnan(look.bounds[STATED])]
    shown = [
        look.margin - max(look.bounds[STATED], 0.0) for look in looks if not math.isnan(look.bounds[STATED])
    ]
    slides = [look for look in looks if look.slides and not math.isnan(look.earliest_slip)]
    return {
        "grasps": len(grasps),
        "margin_below_bound": {
            str(c): _share([any(is_missed(look, c) for look in grasp) for grasp in grasps])
            for c in CONFIDENCES
        },
        "margin_below_bound_at_the_last_look": {
            str(c): _share([is_missed(grasp[-1], c) for grasp in grasps]) for c in CONFIDENCES
        },
        "margin_below_stated_bound_at_each_look": [
            _share([is_missed(one, STATED) for one in at]) for at in zip(*grasps, strict=True)
        ],
        "mean_slack": _mean(slack),
        "median_slack": float(np.median(slack)) if slack else math.nan,
        "mean_slack_above_zero": _mean(shown),
        "looks_without_bound": _share([math.isnan(look.bounds[STATED]) for look in looks]),
        "slides": sum(grasp[-1].slides for grasp in grasps),
        "slides_with_earliest_slip_above_zero": _share([look.earliest_slip > 0.0 for look in slides]),
    }


def most_allowed(grasps: int, confidence: float) -> int:
    """Return how many of so many grasps may lie below a bound of this confidence, by chance."""
    return int(binom.ppf(CHANCE, grasps, 1.0 - confidence))


def missed_goal(told: dict[str, Any], confidence: float = STATED) -> str:
    """Return in words by how much more lie below the bound than their number allows; empty: no more do."""
    count, share = told["grasps"], told["margin_below_bound"][str(confidence)]
    allowed = most_allowed(count, confidence)
    below = round(share * count) if count else 0
    if below <= allowed:
        return ""
    return (
        f"the true margin lies below its {confidence:.0%} bound in {below} of {count} grasps,"
        f" more than {allowed}"
    )


def _share(found: Sequence[bool]) -> float:
    return sum(found) / len(found) if found else math.nan


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else math.nan
