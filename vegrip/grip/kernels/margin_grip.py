"""The margin grip: raise at once, lower slowly, react to slip (:mod:`vegrip.grip.policies.margin_grip`)."""

import math

from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.usual_need import add_need, forget_usual


def forget_grip(f: Floats, t: Wholes) -> None:
    """Forget the past of the need."""
    f.grip.envelope, f.grip.quiet = math.nan, 0.0
    forget_usual(f, t)


def wanted_force(f: Floats, t: Wholes, held: float, dt: float) -> tuple[float, int]:
    """Return the wanted normal force [N] and its reason; an untrusted demand holds."""
    if t.need.slipping == 1:
        return grow_against_slip(f, t, held, dt), REASON_SLIP
    if t.need.trusted == 0:
        return held, REASON_UNTRUSTED
    need = f.demand.least if t.need.in_contact == 1 else 0.0
    return with_play(f, held, follow_need(f, t, held, need, dt))


def follow_need(f: Floats, t: Wholes, held: float, need: float, dt: float) -> float:
    """Follow the need: up at once, down slowly and not below the usual one."""
    before = min(held, f.grip.envelope)  # what a limit cut off was never there; NaN gives held
    usual = add_need(f, t, need, dt)
    floor = max(need, min(usual, before))
    f.grip.quiet = 0.0 if need > before else f.grip.quiet + dt
    if need > before or f.grip.quiet < f.rule.settle_time:
        f.grip.envelope = max(need, before)
    else:
        f.grip.envelope = floor + (before - floor) * math.exp(-dt / f.rule.release_time)
    return f.grip.envelope


def grow_against_slip(f: Floats, t: Wholes, held: float, dt: float) -> float:
    """Lift the envelope for as long as slip is felt."""
    need = f.demand.least if t.need.trusted == 1 else 0.0
    f.grip.envelope = max(held * (1.0 + f.rule.slip_growth * dt), need)
    f.grip.quiet = 0.0
    return f.grip.envelope


def with_play(f: Floats, held: float, envelope: float) -> tuple[float, int]:
    """Keep noise smaller than the play from the actuator."""
    if envelope > held:
        forecast = f.demand.bound >= f.rule.wanted_margin
        return envelope, REASON_FORECAST if forecast else REASON_RAISE
    upper = envelope / (1.0 - f.rule.dead_band)
    if upper < held:
        return upper, REASON_LOWER
    return held, REASON_HOLD
