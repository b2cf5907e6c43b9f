"""The margin grip: raise at once, lower slowly, react to slip (:mod:`vegrip.grip.policies.margin_grip`).

The usual need of the last seconds is a median in slots, to which short errors of a sensor do not matter.
"""

import math

from vegrip.grip.kernels.generated import *


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
    need = max(f.grip.kept, f.demand.least) if t.need.in_contact == 1 else 0.0
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
    growth = f.rule.slide_growth if t.setup.shares == 1 else f.rule.slip_growth
    f.grip.envelope = max(held * (1.0 + growth * dt), need)
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


def forget_usual(f: Floats, t: Wholes) -> None:
    """Begin anew, with the window that is set now."""
    f.grip.slot = f.rule.usual_time / float(USUAL_SLOTS)
    f.grip.present = f.grip.median = -math.inf
    f.grip.filled = 0.0
    f.grip.proven = math.inf
    t.turn.slots = t.turn.next_slot = 0


def add_need(f: Floats, t: Wholes, need: float, dt: float) -> float:
    """Take in a ``need`` [N] that lasted ``dt`` [s]; return the usual one [N]."""
    if f.grip.slot <= 0.0:
        return need
    f.grip.present = max(f.grip.present, need)
    f.grip.filled += dt
    if f.grip.filled >= f.grip.slot:
        f.largest[t.turn.next_slot] = f.grip.present
        t.turn.next_slot = (t.turn.next_slot + 1) % USUAL_SLOTS
        t.turn.slots = min(t.turn.slots + 1, USUAL_SLOTS)
        f.grip.present, f.grip.filled = -math.inf, 0.0
        f.grip.median = median_of_slots(f, t)
        if t.turn.slots > USUAL_SLOTS // 2 and t.setup.shares == 1:
            prove_need(f)
    if t.turn.slots <= USUAL_SLOTS // 2:
        return max(f.grip.median, need)
    return min(f.grip.median, f.grip.proven)


def prove_need(f: Floats) -> None:
    """Keep the lowest median, and let it rise to the present one."""
    usual, proven = f.grip.median, f.grip.proven
    rise = min(f.grip.slot / f.rule.proven_time, 1.0) * (usual - proven) if proven < usual else 0.0
    f.grip.proven = min(usual, proven + rise)


def median_of_slots(f: Floats, t: Wholes) -> float:
    """Return the median of the slots, their largest until half of the window has been seen."""
    for i in range(USUAL_SLOTS):
        if i < t.turn.slots:
            insert_ordered(f, i, f.largest[i])
    half = t.turn.slots // 2 if t.turn.slots > USUAL_SLOTS // 2 else t.turn.slots - 1
    return f.ordered[half]


def insert_ordered(f: Floats, known: int, value: float) -> None:
    """Put ``value`` among the first ``known`` ordered ones."""
    at = known
    while at > 0 and f.ordered[at - 1] > value:
        f.ordered[at] = f.ordered[at - 1]
        at -= 1
    f.ordered[at] = value
