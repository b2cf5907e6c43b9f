"""Lag of the force sensor: ``tau ds/dt = N - s``, the sensor shows s.

A first-order hold like a relaxation branch, exact for a force that is linear within the step. (A zero-order
hold loses half a step: fitted lags came out 0.7 ms too long at 1.4 ms per step.) A lag smears what a pure
delay (:mod:`sensor_delay <vegrip.effects.sensor_delay>`) only moves; slow motions show no difference.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.relaxation import branch
from vegrip.parameters import Parameter


def sense(
    sensed_force: float, dt: float, tau: float, shown: float, felt: float
) -> tuple[float, float, float]:
    """Return what the sensor shows [N], that again as memory, and the force it feels [N]."""
    if tau <= 0.0:
        return sensed_force, sensed_force, sensed_force
    shown = branch(shown, sensed_force, felt, 1.0 / tau, dt)
    return shown, shown, sensed_force


EFFECT = Effect(
    name="sensor_lag",
    summary="the force sensor follows late",
    residual="as dN/dt, trailing, more at higher frequency",
    cites=("Fraden2016",),
    parameters=(Parameter("tau", "s", 3e-3, 0.02, 0.0, 0.2, "time constant of the sensor", null=0.0),),
    states=(
        State("shown", "N", "what the sensor shows", low="force", high="force"),
        State("felt", "N", "force at the end of the last step", low="force", high="force"),
    ),
    hooks=(hook(sense),),
    confounded=("sensor_delay", "displacement_backlash", "fast_damping"),
    experiment="small sines of 8 .. 20 Hz; a synchronisation pulse separates a delay from a lag",
    group="timing",
    shifts_time=True,
    companions=("sensor_delay",),
    trial_sizes=(1.0, 10.0),
    min_amounts=(("tau", 3e-4),),  # a third of a millisecond
    imitated_by="a force whose clock is late by {tau:.2g} s would show nearly the same",
)
