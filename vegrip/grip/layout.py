"""Where everything of one finger that grips lies in its memory, behind what its estimator has there."""

import math
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields
from typing import NamedTuple

from vegrip.clock import NS
from vegrip.config import declaration
from vegrip.estimator.memory import CHANNELS, SampleLayout, Sections, named_sections
from vegrip.grip import records
from vegrip.grip.confirmed_load import CONFIRM_SIZE
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.safety import NOT_MEASURED_S, FailSafeSettings, LimitSettings, WatchdogSettings
from vegrip.grip.settings import ControlSettings, policy_settings
from vegrip.messages import Condition, Reason
from vegrip.types import NamedNumbers

MECHANICAL_CHANNELS = 5
"""The first of them, which a finger that lives never repeats all."""

FORCE_CHANNELS = 4
"""The first of these, forces and torque: the noise of each shows that it lives."""

HISTORY_CHANNELS = len(CHANNELS) + 1
"""Of a state that is kept: its values, and whether the finger touched."""

WINDOW_SLOTS = 25
"""Of the window of the usual need; the largest need of each counts."""


class Rule(NamedTuple):
    """A setting that the step reads, ``key`` of a ``section`` of the control, in units of 1 / ``scale``."""

    section: str
    key: str
    scale: int


GROUPS = {
    "grip": GripSettings,
    "limits": LimitSettings,
    "fail_safe": FailSafeSettings,
    "watchdog": WatchdogSettings,
}
OF_GRASP = ("known_probability", "drive_lag", "burst_rate")
"""Settings that the fingers follow together, and not the step of one."""
RENAMED = {"probability": "QUANTILE", "force": "SAFE_FORCE"}


def _rules() -> Iterator[tuple[str, Rule]]:
    for section, group in GROUPS.items():
        for one in fields(group):
            if one.type is float and one.name not in OF_GRASP:  # others are written by write_rules
                is_time = section == "watchdog" and declaration(group, one.name).unit == "s"
                name = RENAMED.get(one.name, one.name.upper())
                yield name, Rule(section, one.name, NS if is_time else 1)


RULES = dict(_rules())
"""By the name of their places. Times of the watchdog are in [ns], the probability of the whole grasp is a
quantile of each finger."""

REALS: Sections = {
    "RULE": tuple(RULES),
    "LOWEST": len(CHANNELS), "HIGHEST": len(CHANNELS),
    "REPEATED": MECHANICAL_CHANNELS, "REPEATED_FORCE": 1,
    "WATCH": records.Watch,
    **dict.fromkeys(("NOISE_LAST", "NOISE_CHANGE", "REPEAT_LIMIT", "REPEATS", "TURNS"), FORCE_CHANNELS),
    "CONFIRMED": CONFIRM_SIZE,
    "DEMAND": records.Demand, "ASKED": records.Asked, "SHARED": records.Shared,
    "TRANSFER": records.Transfer, "PUBLISHED": records.Published, "GRIP": records.Grip,
    "LARGEST": WINDOW_SLOTS, "ORDERED": WINDOW_SLOTS,
}  # fmt: skip
"""RULE: settings; LOWEST, HIGHEST: believable ranges of the channels; REPEATED, REPEATED_FORCE: the
mechanical channels last seen; CONFIRMED: the load that counts (:mod:`vegrip.grip.confirmed_load`); LARGEST:
the slots of the usual need; ORDERED: scratch. Of each force (:mod:`vegrip.grip.kernels.noise`), NOISE_LAST,
NOISE_CHANGE: value and change before; REPEAT_LIMIT: repetitions in a row that are frozen, inf: it has too
little noise; REPEATS: share of the values that repeat the one before; TURNS: of changes that turn back."""

WHOLES: Sections = {
    "SETUP": records.Setup, "LINE": records.Line, "INPUT": records.Input, "FAULTS": len(Condition),
    "REPEAT_RUN": FORCE_CHANNELS, "REPEAT_SINCE": FORCE_CHANNELS, "NOISE_COUNT": FORCE_CHANNELS,
    "NEED": records.Need, "TURN": records.Turn,
}  # fmt: skip
"""FAULTS: counts by condition. Of each force, REPEAT_RUN: repetitions in a row; REPEAT_SINCE: [ns] when the
first came; NOISE_COUNT: values that told its noise."""

NODE_REALS: Sections = {"BASELINE": records.Baseline, "OWN": records.Own}
NODE_WHOLES: Sections = {"CHOICE": records.Choice}
"""Of a finger in a node."""


@dataclass(frozen=True)
class FingerLayout(SampleLayout):
    """Sizes and places for one finger.

    Args:
        history: states that are kept for others; 0 keeps none.
        is_shared: whether it is one of a node: fingers can share friction and lead their loads, and
            policies can be chosen.

    """

    history: int = 0
    is_shared: bool = False

    def real_sections(self) -> Iterator[tuple[str, tuple[str, ...], int]]:
        yield from super().real_sections()
        yield from named_sections(REALS)
        if self.is_shared:
            yield from named_sections(NODE_REALS)
        yield "HISTORY", (), self.history * HISTORY_CHANNELS

    def whole_sections(self) -> Iterator[tuple[str, tuple[str, ...], int]]:
        """Yield name, names within and length of the sections of whole numbers."""
        yield from super().whole_sections()
        yield from named_sections(WHOLES)
        if self.is_shared:
            yield from named_sections(NODE_WHOLES)
        yield "HISTORY_STAMP", (), self.history
        yield "HISTORY_SEQ", (), self.history

    def constants(self) -> str:
        """Return the places, and the codes of conditions and reasons, as program text."""
        return "\n".join([
            super().constants(),
            *(f"CONDITION_{one.name} = {one.value}" for one in Condition),
            *(f"REASON_{one.name} = {one.value}" for one in Reason),
            f"HISTORY_STATES = {self.history}",
        ])  # fmt: skip


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
    if watchdog.force_frozen_after == NOT_MEASURED_S:
        memory["RULE_DOUBT_AFTER"], memory["RULE_FROZEN_CHANCE"] = math.inf, 0.0
    memory["SETUP_RECOVER_AFTER"] = watchdog.recover_after
    bounds = astuple(watchdog.ranges)
    memory.section("LOWEST")[:] = [low for low, _ in bounds]
    memory.section("HIGHEST")[:] = [high for _, high in bounds]


def write_choice(memory: NamedNumbers, settings: ControlSettings) -> None:
    """Write which policy rules, and its settings where it is one to compare with."""
    policy = settings.policy if settings.is_built_in else ""
    memory["CHOICE_POLICY"] = STEP_POLICIES.index(policy) if policy else OWN_POLICY
    if policy not in {"", MARGIN}:
        baseline = policy_settings(settings)
        for name in records.Baseline.__annotations__:
            memory[f"BASELINE_{name.upper()}"] = getattr(baseline, name, 0.0)
