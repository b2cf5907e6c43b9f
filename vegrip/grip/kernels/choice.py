"""What a finger of a node is asked to do by choice: which policy finds its force, and who shares the grasp.

The baseline policies are for comparison (:mod:`vegrip.grip.policies.baselines`). A policy in Python answers
between two halves of the step: it starts from ``OWN_BASE``, and its answer comes as ``OWN_FORCE``.
"""

import math

from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.margin_grip import forget_grip, wanted_force
from vegrip.grip.kernels.share import balanced_force

POLICY_MARGIN = 0  # numbers as in vegrip.grip.layout.STEP_POLICIES
POLICY_CONSTANT = 1
POLICY_CONE = 2
POLICY_ELASTIC = 3  # and beyond it: a policy in Python


def asks_least_force(t: Wholes) -> bool:
    """Return whether the policy looks at the least force."""
    return t.choice.asks == 1


def forget_policy(f: Floats, t: Wholes) -> None:
    """Forget the past of the need."""
    forget_grip(f, t)
    t.choice.forgotten += 1


def asked_force(f: Floats, t: Wholes, base: float, dt: float) -> tuple[float, int]:
    """Return the normal force [N] that the policy asks for, and its reason."""
    policy = t.choice.policy
    if policy == POLICY_MARGIN:
        f.own.force, t.choice.reason = wanted_force(f, t, base, dt)
    elif policy <= POLICY_ELASTIC:
        force = baseline_force(f, policy)
        t.choice.reason = direction(base, force)
        f.own.force = base if math.isnan(force) else force
    return f.own.force, t.choice.reason


def direction(base: float, force: float) -> int:
    """Return why a baseline policy asks for ``force`` [N]; a load that was not measured gives NaN."""
    if math.isnan(force):
        return REASON_UNTRUSTED
    if force > base:
        return REASON_RAISE
    return REASON_LOWER if force < base else REASON_HOLD


def baseline_force(f: Floats, policy: int) -> float:
    """Return the force [N] of a baseline policy; NaN: its load was not measured."""
    if policy == POLICY_CONSTANT:
        return f.baseline.force
    friction, more = f.baseline.friction, 1.0 + f.baseline.safety
    if policy == POLICY_CONE:
        return more * f.demand.load / friction
    torque = 0.0 if math.isnan(f.demand.torque) else f.demand.torque
    radius, power = f.baseline.radius, f.baseline.power
    exponent = f.baseline.exponent
    return more * least_normal_force(f.demand.load, torque, friction, radius, exponent, 1.0, power, 0.0)


def shared_force(f: Floats, t: Wholes, g: GraspMemory) -> float:
    """Return this finger's share of the grasp [N]: balanced against the thumb, or as Python has shared it."""
    return f.own.share if t.choice.share == 1 else balanced_force(t, g)


def note_command(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Let the grasp know what this finger is commanded."""
    if t.setup.finger < BELIEF_MOST:
        g.balance.pressed[t.setup.finger] = f.grip.held


def pressed_by_others(t: Wholes, g: GraspMemory) -> float:
    """Return what the fingers are commanded [N] that press against this one; NaN: none do."""
    if t.setup.finger != t.setup.thumb or t.choice.share == 1 or t.setup.fingers > BELIEF_MOST:
        return math.nan
    pressed = 0.0
    for i in range(t.setup.fingers):
        if i != t.setup.finger and not math.isnan(g[i]):
            pressed += g.balance.pressed[i]
    return pressed if pressed > 0.0 else math.nan
