"""One run of two holds: the gripper, its pads and a rule in simulated time."""

import math
from dataclasses import dataclass

import numpy as np

from validation.controllers.position_hold.controllers import RULES, HoldRule
from validation.controllers.position_hold.gripper import Gripper
from validation.controllers.position_hold.scenario import (
    LIFT_END_S,
    RECOVERY_S,
    Load,
    PositionHold,
    draw_hold,
)


@dataclass(frozen=True)
class HoldTrial:
    """Which rule, with which knob, on which pads and loads."""

    rule: str
    knob: float
    material: int
    seed: int


@dataclass(frozen=True)
class HoldResult:
    """What came of one hold; forces are those of a pad, true, after the lift."""

    slipped: bool
    tightenings: int
    force: float  # [N] mean
    least: float  # [N] mean of the least possible at every instant
    closing: float  # [N] greatest
    oracle: float  # [N] mean force of a single closing that just suffices at the end


def run_holds(trial: HoldTrial) -> tuple[HoldResult, ...]:
    """Run the holds of one trial, one after the other, with the same rule."""
    holds = draw_hold(trial.material, trial.seed)
    rule: HoldRule = RULES[trial.rule](trial.knob)
    gripper = Gripper(holds.pad, np.random.default_rng([trial.material, trial.seed, 19]))
    results = []
    for load in holds.loads:
        results.append(hold(gripper, rule, holds, load))
        gripper.open(RECOVERY_S)
    return tuple(results)


def hold(gripper: Gripper, rule: HoldRule, holds: PositionHold, load: Load) -> HoldResult:
    """Close, hold ``load`` to its end, and tighten again where the rule wants it."""
    pad = holds.pad
    rule.begin(pad, holds.stated_friction, load)
    gripper.load = load
    moving, forces, needs, greatest = True, [], [], 0.0
    slipped, depth, need = False, -1.0, math.inf
    while gripper.time - gripper.closed_at < load.duration or math.isinf(gripper.closed_at):
        held = gripper.time - gripper.closed_at
        rule.feel(gripper.sense(), held if not math.isinf(held) else -1.0)
        if not moving and rule.wants_more():
            moving = True
            gripper.tightenings += 1
        if moving:
            moving = not gripper.move(rule.is_enough)
            if not moving and math.isinf(gripper.closed_at):
                gripper.closed_at = gripper.time
        else:
            gripper.stand()
        force = gripper.pressed.force
        greatest = max(greatest, force)
        if gripper.lifted > 0.0:
            if depth != gripper.pressed.depth:
                depth = gripper.pressed.depth
                need = load.need(pad.friction, pad.contact_radius(depth))
            slipped = slipped or force < gripper.lifted * need
            if gripper.time - gripper.closed_at >= LIFT_END_S:
                forces.append(force)
                needs.append(need)
    return HoldResult(
        slipped=slipped,
        tightenings=gripper.tightenings,
        force=float(np.mean(forces)),
        least=float(np.mean(needs)),
        closing=greatest,
        oracle=least_single_closing(holds, load),
    )


def least_single_closing(holds: PositionHold, load: Load) -> float:
    """Return the mean force [N] of the least single closing that holds ``load`` to its end.

    It is found by closing to one force after another on the same pad, all true values known.
    """
    pad = holds.pad

    def held(knob: float) -> tuple[float, float]:
        """Return the force left over the need at the end, and the mean force."""
        gripper = Gripper(pad, np.random.default_rng(0))
        gripper.position = 0.0

        def is_enough(depth: float, force: float) -> bool:
            return force >= knob * load.need(pad.friction, pad.contact_radius(depth))

        while not gripper.move(is_enough):
            pass
        depth, forces = gripper.pressed.depth, []
        for step in np.diff(np.linspace(0.0, load.duration**0.5, 30) ** 2):
            gripper.pressed.press(depth, float(step))
            forces.append((step, gripper.pressed.force))
        weights, values = np.array(forces).T
        need = load.need(pad.friction, pad.contact_radius(depth))
        return float(values[-1] / need), float(np.average(values, weights=weights))

    low, high = 1.0, 4.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if held(middle)[0] >= 1.0 else (middle, high)
    return held(high)[1]
