"""How well each parameter must be known, and how well it is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vegrip.identification.fit.result import Fit
from vegrip.parameters import Parameter
from vegrip.types import Floats

GOALS: Mapping[str, float] = {"K": 0.03, "p": 0.03, "c1": 0.02, "nu1": 0.15, "k0": 0.1, "mu": 0.05}
"""Standard error that suffices, of the coordinate: relative where a parameter is fitted by its logarithm."""
SHARE = 0.3  # of the prior's standard deviation, for parameters of further effects


@dataclass(frozen=True)
class Known:
    """One parameter."""

    symbol: str
    effect: str
    value: float
    std: float  # of its coordinate
    goal: float
    unit: str
    is_log: bool

    @property
    def is_known(self) -> bool:
        """Whether it is known well enough."""
        return self.std <= self.goal

    def errors_off(self, true: float) -> float:
        """Return by how many standard errors the value is off ``true``."""
        off = math.log(self.value / true) if self.is_log else self.value - true
        return off / self.std

    def as_dict(self) -> dict[str, object]:
        """Return it for JSON."""
        return {
            "effect": self.effect,
            "value": self.value,
            "std": self.std,
            "goal": self.goal,
            "unit": self.unit,
            "scale": "log" if self.is_log else "identity",
            "known": self.is_known,
        }


def known_of(fit: Fit) -> list[Known]:
    """Return how well each parameter of the model is known."""
    found, values = [], fit.model.values
    for symbol in fit.problem.symbols:
        declared = fit.declared(symbol)
        if declared is not None:
            effect, parameter = declared
            found.append(
                Known(
                    symbol,
                    effect.name,
                    values[symbol].value,
                    fit.std[symbol],
                    goal_of(parameter),
                    parameter.unit,
                    parameter.transform == "log",
                )
            )
    return found


def goal_of(parameter: Parameter) -> float:
    """Return the standard error that suffices for a parameter."""
    return GOALS.get(parameter.symbol, SHARE * parameter.std)


def distance(stds: Floats, goals: Floats) -> float:
    """Return how far the parameters are from being known [nats]: 0 when all are."""
    return float(np.sum(np.log(np.maximum(stds / goals, 1.0))))
