"""The settings of the control as the finger step reads them: every parameter by the name of its place."""

from vegrip.clock import NS
from vegrip.grip.safety.ranges import bounds_of
from vegrip.grip.settings import ControlSettings
from vegrip.types import NamedNumbers

MARGIN = "margin"
STEP_POLICIES = (MARGIN, "constant", "cone", "elastic")
"""Those of the step, by their numbers there (:mod:`vegrip.grip.kernels.choice`)."""
OWN_POLICY = len(STEP_POLICIES)
"""Number of a policy in Python."""


def write_rules(memory: NamedNumbers, settings: ControlSettings) -> None:
    """Write all settings but those that follow from the whole grasp, such as each finger's confidence."""
    grip, limits, safe, watchdog = settings.grip, settings.limits, settings.fail_safe, settings.watchdog
    rules = {
        "WANTED_MARGIN": grip.wanted_margin, "DEAD_BAND": grip.dead_band, "RELEASE_TIME": grip.release_time,
        "SETTLE_TIME": grip.settle_time, "USUAL_TIME": grip.usual_time, "PROVEN_TIME": grip.proven_time,
        "SLIP_GROWTH": grip.slip_growth,
        "MIN_FORCE": limits.min_force, "MAX_FORCE": limits.max_force, "RAISE_RATE": limits.raise_rate,
        "LOWER_RATE": limits.lower_rate, "LIFETIME": limits.lifetime,
        "SAFE_FORCE": safe.force, "HOLD_TIME": safe.hold_time, "RAMP_RATE": safe.ramp_rate,
        "TIME_OUT": watchdog.time_out * NS, "FROZEN_AFTER": watchdog.frozen_after * NS,
        "FORCE_FROZEN_AFTER": watchdog.force_frozen_after * NS, "DOUBT_AFTER": watchdog.doubt_after * NS,
        "FROZEN_CHANCE": watchdog.frozen_chance, "STUCK_TRAVEL": watchdog.stuck_travel,
    }  # fmt: skip
    for name, value in rules.items():
        memory[f"RULE_{name}"] = value
    memory["SETUP_RECOVER_AFTER"] = watchdog.recover_after
    bounds = bounds_of(watchdog.ranges)
    memory.section("LOWEST")[:] = [low for low, _ in bounds]
    memory.section("HIGHEST")[:] = [high for _, high in bounds]


def write_choice(memory: NamedNumbers, settings: ControlSettings) -> None:
    """Write which policy rules, and its settings where it is one to compare with."""
    policy = settings.policy if settings.is_built_in else ""
    memory["CHOICE_POLICY"] = STEP_POLICIES.index(policy) if policy else OWN_POLICY
    if settings.policy == "constant":
        memory["BASELINE_FORCE"] = settings.constant.force
    if settings.policy not in {"cone", "elastic"}:
        return
    baseline = settings.cone if settings.policy == "cone" else settings.elastic
    for name in ("friction", "safety", "radius", "power", "exponent"):
        memory[f"BASELINE_{name.upper()}"] = getattr(baseline, name, 0.0)
