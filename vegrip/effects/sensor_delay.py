"""Delay of the force sensor: what it shows is late by T, ``y(t) = N(t - T)``.

A bus, a buffer or a filter of high order delays the force without smearing it as a lag does. A delay has no
states of its own; here it is ``e^-sT`` by its Pade approximant of numerator 2 and denominator 3, exact to the
fifth order in sT. That is one real and two complex rates, each a relaxation branch, exact for a force that is
linear within the step. The amplitude is right to 1 % and the angle to 0.5 degrees up to ``0.3 / T`` [Hz].
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.relaxation import branch
from vegrip.parameters import Parameter

# rates times T, and the amplitudes of the branches; the second of the pair has the imaginary parts
RATE = 3.6378342527444905
PAIR_RATE, PAIR_TURN = 2.6810828736277577, 3.0504301992474137
WEIGHT = 5.029777857812426
PAIR_WEIGHT, PAIR_SKEW = -4.02977785781242, -1.4730151100815648


def sense(
    sensed_force: float,
    dt: float,
    T_y: float,
    real_y: float,
    even_y: float,
    odd_y: float,
    felt_y: float,
) -> tuple[float, float, float, float, float]:
    """Return what the sensor shows [N], its three branches, and the force it feels [N]."""
    if T_y <= 0.0:
        return sensed_force, sensed_force, sensed_force, 0.0, sensed_force
    if dt > 0.0:
        h = dt / T_y
        risen = sensed_force - felt_y
        real_y = branch(real_y, sensed_force, felt_y, RATE, h)
        # z+ = N_0 + E (z - N_0) + (1 - phi) (N_1 - N_0), all of them complex
        a, b = PAIR_RATE * h, PAIR_TURN * h
        kept = math.exp(-a)
        keeps, turns = kept * math.cos(b), -kept * math.sin(b)
        size = a * a + b * b
        phi, phi_odd = (a * (1.0 - keeps) - b * turns) / size, -(a * turns + b * (1.0 - keeps)) / size
        away = even_y - felt_y
        even_y, odd_y = (
            felt_y + keeps * away - turns * odd_y + (1.0 - phi) * risen,
            turns * away + keeps * odd_y - phi_odd * risen,
        )
    shown = WEIGHT * real_y + PAIR_WEIGHT * even_y + PAIR_SKEW * odd_y
    return shown, real_y, even_y, odd_y, sensed_force


EFFECT = Effect(
    name="sensor_delay",
    summary="the force sensor shows what was, unchanged",
    residual="as dN/dt, trailing, jerks keep their shape",
    cites=("Fraden2016",),
    parameters=(
        Parameter("T_y", "s", 3e-3, 0.02, 0.0, 0.2, "time by which what is shown is late", null=0.0),
    ),
    states=(
        State("real_y", "N", "branch of the real rate", low="force", high="force"),
        State("even_y", "N", "real part of the complex branch", low="force", high="force"),
        State("odd_y", "N", "imaginary part of it"),
        State("felt_y", "N", "force at the end of the last step", low="force", high="force"),
    ),
    hooks=(hook(sense),),
    confounded=("sensor_lag",),
    experiment="small sines of 2 .. 20 Hz; a synchronisation pulse",
    group="timing",
    shifts_time=True,
    companions=("sensor_lag",),
    min_amounts=(("T_y", 3e-4),),
    trial_sizes=(1.0, 10.0),
    imitated_by="a force whose clock is late by {T_y:.2g} s would show the same",
)
