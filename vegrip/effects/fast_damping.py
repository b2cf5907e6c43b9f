"""Damping faster than any branch: ``N += eta K(x) v``, ``K = dN_e / dx``, ``v = d delta / dt``.

A relaxation branch whose rate is beyond the sampling, or the Kelvin-Voigt damping of a contact whose
damping vanishes with its stiffness ([HuntCrossley1975]_), so that the force is continuous at contact. It
leads the displacement where :mod:`sensor_lag <vegrip.effects.sensor_lag>` trails it.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def force(force: float, stiffness: float, speed: float, eta: float) -> float:
    """Return the force [N]."""
    return force + eta * stiffness * speed


EFFECT = Effect(
    name="fast_damping",
    summary="a viscous force in phase with the speed, faster than any relaxation that is seen",
    residual="as stiffness times speed, leading",
    cites=("HuntCrossley1975",),
    parameters=(Parameter("eta", "s", 2e-3, 2e-3, 0.0, 0.1, "time by which the force leads", null=0.0),),
    hooks=(hook(force),),
    confounded=("displacement_lag", "sensor_lag", "rate_stiffening"),
    experiment="small sines of 5 .. 20 Hz",
    shifts_time=True,
    companions=("displacement_lag",),
    imitated_by="a force whose clock is early by {eta:.2g} s would show nearly the same",
)
