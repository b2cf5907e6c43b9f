"""The margin grip: raise at once, lower slowly, react to slip (:mod:`vegrip.grip.policies.margin_grip`)."""

import math

from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.usual_need import add_need, forget_usual


def forget_grip(f: Floats, t: Wholes) -> None:
    """Forget the past of the need."""
    f[GRIP_ENVELOPE], f[GRIP_QUIET] = math.nan, 0.0
    forget_usual(f, t)


def wanted_force(f: Floats, t: Wholes, held: float, dt: float) -> tuple[float, int]:
    """Return the wanted normal force [N] and its reason; an untrusted demand holds."""
    if t[NEED_SLIPPING] == 1:
        return grow_against_slip(f, t, held, dt), REASON_SLIP
    if t[NEED_TRUSTED] == 0:
        return held, REASON_UNTRUSTED
    need = f[DEMAND_LEAST] if t[NEED_IN_CONTACT] == 1 else 0.0
    return with_play(f, held, follow_need(f, t, held, need, dt))


def follow_need(f: Floats, t: Wholes, held: float, need: float, dt: float) -> float:
    """Follow the need: up at once, down slowly and not below the usual one."""
    before = min(held, f[GRIP_ENVELOPE])  # what a limit cut off was never there; NaN gives held
    usual = add_need(f, t, need, dt)
    floor = max(need, min(usual, before))
    f[GRIP_QUIET] = 0.0 if need > before else f[GRIP_QUIET] + dt
    if need > before or f[GRIP_QUIET] < f[RULE_SETTLE_TIME]:
        f[GRIP_ENVELOPE] = max(need, before)
    else:
        f[GRIP_ENVELOPE] = floor + (before - floor) * math.exp(-dt / f[RULE_RELEASE_TIME])
    return f[GRIP_ENVELOPE]


def grow_against_slip(f: Floats, t: Wholes, held: float, dt: float) -> float:
    """Lift the envelope for as long as slip is felt."""
    need = f[DEMAND_LEAST] if t[NEED_TRUSTED] == 1 else 0.0
    f[GRIP_ENVELOPE] = max(held * (1.0 + f[RULE_SLIP_GROWTH] * dt), need)
    f[GRIP_QUIET] = 0.0
    return f[GRIP_ENVELOPE]


def with_play(f: Floats, held: float, envelope: float) -> tuple[float, int]:
    """Keep noise smaller than the play from the actuator."""
    if envelope > held:
        forecast = f[DEMAND_BOUND] >= f[RULE_WANTED_MARGIN]
        return envelope, REASON_FORECAST if forecast else REASON_RAISE
    upper = envelope / (1.0 - f[RULE_DEAD_BAND])
    if upper < held:
        return upper, REASON_LOWER
    return held, REASON_HOLD
