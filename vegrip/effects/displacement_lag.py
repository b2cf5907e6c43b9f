"""Lag of the displacement sensor: ``tau_d d(delta)/dt = x - delta``, so ``x = delta + tau_d v``.

The tip is ahead of what the sensor of the displacement shows, and the force seems to lead. Damping
(:mod:`fast_damping <vegrip.effects.fast_damping>`) leads too, but touches no earlier.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def tip(x: float, speed: float, tau_d: float) -> float:
    """Return where the tip is [m]."""
    return x + tau_d * speed


EFFECT = Effect(
    name="displacement_lag",
    summary="the displacement sensor follows late",
    residual="as stiffness times speed, leading; the touch too",
    cites=("Fraden2016",),
    parameters=(
        Parameter("tau_d", "s", 3e-3, 0.02, 0.0, 0.2, "time constant of the displacement sensor", null=0.0),
    ),
    hooks=(hook(tip),),
    confounded=("fast_damping",),
    experiment="fast touches from air, and small sines of 2 .. 20 Hz",
    shifts_time=True,
    companions=("fast_damping",),
    min_amounts=(("tau_d", 3e-4),),
    trial_sizes=(1.0, 10.0),
    imitated_by="a force whose clock is early by {tau_d:.2g} s would show nearly the same",
)
