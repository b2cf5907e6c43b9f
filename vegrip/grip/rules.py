"""The settings of the control as the finger step reads them: every parameter by the name of its place."""

from vegrip.grip.layout import RULES
from vegrip.grip.safety import bounds_of
from vegrip.grip.settings import ControlSettings
from vegrip.types import NamedNumbers

MARGIN = "margin"
STEP_POLICIES = (MARGIN, "constant", "cone", "elastic")
"""Those of the step, by their numbers there (:mod:`vegrip.grip.kernels.choice`)."""
OWN_POLICY = len(STEP_POLICIES)
"""Number of a policy in Python."""


def write_rules(memory: NamedNumbers, settings: ControlSettings) -> None:
    """Write all settings but those that follow from the whole grasp, such as each finger's confidence."""
    for name, (section, key, scale) in RULES.items():
        if name != "QUANTILE":
            memory[f"RULE_{name}"] = getattr(getattr(settings, section), key) * scale
    watchdog = settings.watchdog
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
