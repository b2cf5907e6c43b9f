"""Drift of the force sensor's zero: ``y = N + b``, ``db/dt = r``.

The steady part of it. What wanders at random is not in the model: the estimator carries it as its bias. r
is in units of K per second.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def sense(sensed_force: float, dt: float, K: float, r_F: float, b_F: float) -> tuple[float, float]:
    """Return what the sensor shows [N] and its zero [N]."""
    b_F = b_F + r_F * K * dt
    return sensed_force + b_F, b_F


EFFECT = Effect(
    name="force_drift",
    summary="the zero of the force sensor moves steadily",
    residual="in air, growing with time",
    cites=("Fraden2016",),
    parameters=(Parameter("r_F", "1/s", 1e-4, 3e-4, -1.0, 1.0, "drift in K per second", null=0.0, of="K/s"),),
    states=(State("b_F", "N", "zero of the force sensor", lasting=True),),
    hooks=(hook(sense),),
    confounded=("second_relaxation", "temperature_shift", "adhesion", "approach_tilt"),
    experiment="air before and after every trial",
)
