"""Simulate, then fit: every parameter of every effect comes back from what the model itself has made."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from vegrip.effects import BUILT_IN, effect
from vegrip.model import BASE
from vegrip.parameters import coordinate

ADDED = [name for name in BUILT_IN if name not in BASE]
TOGETHER = ("K", "p", "c1", "nu1", "mu")
"""Parameters of the base model that are fitted with those of the effect."""


@pytest.mark.parametrize("name", ADDED)
def test_fit_recovers_the_parameters(name, model_with, rich):
    """From 0.3 prior standard deviations off back to 1 % of one; no noise, all that can be measured."""
    truth = model_with(name)
    declared = [truth.parameters[s][1] for s in (*TOGETHER, *(p.symbol for p in effect(name).parameters))]
    std = np.array([p.std for p in declared])
    best = np.array([coordinate(p, truth.values[p.symbol].value) for p in declared])
    low, high = (np.array([coordinate(p, getattr(p, end)) for p in declared]) for end in ("low", "high"))
    outputs = observed(truth, declared, rich)
    measured = outputs(best)
    start = np.clip(best + 0.3 * std, low, high)
    start = np.where(start == best, best - 0.3 * std, start)
    fit = least_squares(
        lambda u: outputs(np.clip(u, low, high)) - measured, start, method="lm", x_scale=std, max_nfev=600
    )
    away = {
        p.symbol: float(d) for p, d in zip(declared, (np.clip(fit.x, low, high) - best) / std, strict=True)
    }
    assert max(map(abs, away.values())) < 0.01, away


def observed(model, declared, motion):
    """Give the function from coordinates to forces, radius, 1/k and friction, scaled to order one."""
    places = [list(model.parameters).index(p.symbol) for p in declared]
    log = np.array([p.transform == "log" for p in declared])
    module, inputs, K = model.compiled(), motion.inputs(), model.values["K"].value

    def outputs(u):
        values, out = model.vector, np.empty((motion.t.size, 7))
        values[places] = np.where(log, np.exp(np.where(log, u, 0.0)), u)
        module.run(values, model.initial_states, motion.t, inputs, out)
        out[:, 5] = 1.0 / out[:, 5]
        return (out[::4, 2:] / np.array([K, K, model.tip_radius, 1.0, 1.0])).ravel()

    return outputs
