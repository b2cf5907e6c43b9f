"""What is left of a held force at the end of the hold, by vegrip's estimator and its uncertainty.

At a held indentation the force falls as the branches of the model relax:

    ``N(T) = N(0) - sum_i (c_i N_e - z_i) (1 - exp(-nu_i T))``,   ``N_e = N(0) + sum_i z_i`` .

The states z_i and the parameters c_i, ln nu_i are drawn from the estimator's joint Gaussian; what is left is
a quantile over the draws. (The forecast of the estimator itself takes a fixed relative spread of what is to
relax; it suits horizons of a second, not of a minute.)
"""

from dataclasses import replace

import numpy as np

from validation.controllers.position_hold.gripper import (
    DEPTH_NOISE_M,
    FORCE_NOISE_N,
    TANGENTIAL_NOISE_N,
    TORQUE_NOISE_NM,
)
from vegrip.effects import effect
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import ContactModel, paper_model
from vegrip.parameters import changed, declared
from vegrip.types import Floats

PRIOR = {"c1": (0.25, 0.1), "nu1": (1.5, 1.2), "c2": (0.2, 0.1), "nu2": (0.06, 1.2)}
"""Value and std of the coordinate: what is known of soft pads as a class, of this one nothing."""
TIP_RADIUS_M = 11e-3
"""What the estimator is told of every pad; their own scatters by a third about it."""
DRAWS = 200
MOST_RELAXED = 0.65  # sum of the c_i [-] of soft pads


def pad_model() -> ContactModel:
    """Return the model of a pad of unknown material: two relaxation times with wide priors."""
    base = paper_model(TIP_RADIUS_M)
    second = effect("second_relaxation")
    effects = list(base.effects)
    effects.insert(2, second)
    values = {**base.values, **{p.symbol: declared(p) for p in second.parameters}}
    for symbol, (value, std) in PRIOR.items():
        values[symbol] = changed(values[symbol], value=value, std=std)
    values["K"] = changed(values["K"], std=0.8)
    values["p"] = changed(values["p"], std=0.2)
    return replace(base, effects=tuple(effects), values=values)


class HoldForecast:
    """The estimator of a pad, and the force that it expects to be left."""

    def __init__(self) -> None:
        noise = SensorNoise(FORCE_NOISE_N, DEPTH_NOISE_M, TANGENTIAL_NOISE_N, TORQUE_NOISE_NM)
        settings = EstimatorSettings(learning_rest=600.0)  # [s] a hold of a minute teaches to its end
        self.estimator = ContactEstimator(pad_model(), noise, settings)
        names = self.estimator.state_names
        self._places = [names.index(n) for n in ("z1", "z2", "c1", "c2", "ln nu1", "ln nu2")]
        self._normal = np.random.default_rng(5).standard_normal((DRAWS, len(self._places)))

    def feel(self, state: FingertipState) -> None:
        """Take one sample."""
        self.estimator.assimilate(state)

    @property
    def force(self) -> float:
        """The normal force as it is now [N]."""
        return self.estimator.normal_force.value

    def left_after(self, times: Floats) -> Floats:
        """Return N(T) / N(0) [-] of every draw at ``times`` [s] of a hold that begins now; (draws, times)."""
        mean = np.array([e.value for e in self.estimator.state.values()])[self._places]
        covariance = self.estimator.covariance[np.ix_(self._places, self._places)]
        spread, axes = np.linalg.eigh(covariance)
        drawn = mean + self._normal @ (axes * np.sqrt(np.maximum(spread, 0.0))).T
        z, c, nu = drawn[:, :2], np.clip(drawn[:, 2:4], 0.0, MOST_RELAXED), np.exp(drawn[:, 4:])
        c *= np.minimum(1.0, MOST_RELAXED / np.maximum(c.sum(axis=1, keepdims=True), 1e-9))
        now = max(self.force, 1e-6)
        elastic = now + z.sum(axis=1, keepdims=True)
        toward = c * elastic - z  # [N] that each branch has still to lose
        lost = np.einsum("di,dit->dt", toward, -np.expm1(-nu[:, :, None] * times))
        left: Floats = np.clip(1.0 - lost / now, 0.0, 1.0)  # what was pressed more deeply would gain
        return left
