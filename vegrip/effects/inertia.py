"""Inertia of what lies before the sensor: ``y = N + M d2 delta / dt2``, in air too.

M is given as ``M x_ref / K`` [s^2], the square of the time in which the contact would swing. The
acceleration is the change of the speed from step to step; as a speed belongs to the middle of its step,
that takes half of both steps. Sensed, not felt: the force of the contact and its slip limit do not know of
it.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def sense(
    sensed_force: float,
    speed: float,
    dt: float,
    reference_depth: float,
    K: float,
    M_K: float,
    v_before: float,
    dt_before: float,
    acceleration: float,
) -> tuple[float, float, float, float]:
    """Return what the sensor shows [N]; speed [m/s] and length [s] of this step; acceleration [m/s^2]."""
    if dt > 0.0:
        acceleration = 2.0 * (speed - v_before) / (dt + dt_before)
        v_before, dt_before = speed, dt
    return sensed_force + M_K * K / reference_depth * acceleration, v_before, dt_before, acceleration


EFFECT = Effect(
    name="inertia",
    summary="the mass before the sensor shows when it is accelerated",
    residual="as the acceleration, in air too",
    cites=("Fraden2016",),
    parameters=(
        Parameter("M_K", "s^2", 2e-5, 2e-5, 0.0, 1e-2, "mass over K/x_ref", null=0.0, of="K s^2/x_ref"),
    ),
    states=(
        State("v_before", "m/s", "speed in the last step"),
        State("dt_before", "s", "length of the last step"),
        State("acceleration", "m/s^2", "acceleration at the last step"),
    ),
    hooks=(hook(sense),),
    confounded=("sensor_lag",),
    experiment="fast strokes in air",
    shifts_time=True,
    min_gain=20.0,  # errors of the motion are accelerations too
)
