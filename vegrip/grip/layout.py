"""Where everything of one finger that grips lies in its memory, behind what its estimator has there."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import NamedTuple

from vegrip.clock import NS
from vegrip.config import declaration
from vegrip.estimator.memory import CHANNELS, SampleLayout, Sections, named_sections
from vegrip.grip.confirmed_load import CONFIRM_SIZE
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.safety.fail_safe import FailSafeSettings
from vegrip.grip.safety.limits import LimitSettings
from vegrip.grip.safety.watchdog import WatchdogSettings
from vegrip.messages import Condition, Reason

MECHANICAL_CHANNELS = 5
"""The first of them, which a finger that lives never repeats all."""

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
OF_GRASP = ("slip_every", "known_probability", "drive_lag", "burst_rate")
"""Settings that the fingers follow together, and not the step of one."""
RENAMED = {"probability": "QUANTILE", "force": "SAFE_FORCE"}


def _rules() -> Iterator[tuple[str, Rule]]:
    for section, group in GROUPS.items():
        for one in fields(group):
            if one.type is float and one.name not in OF_GRASP:
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
    "WATCH": ("NOISE_LAST", "CHANGE", "REPEAT_LIMIT", "REPEATS", "TURNS", "LEVEL"),
    "CONFIRMED": CONFIRM_SIZE,
    "DEMAND": ("LEAST", "LOAD", "TORQUE", "BOUND"),
    "ASKED": ("MARGIN", "QUANTILE"),
    "SHARED": (
        "KNOWN_QUANTILE", "WIDEST", "LOAD_NOISE", "SEEN", "SITE", "SITE_WEIGHTED", "BEFORE", "BEFORE_VAR",
        "FLAG", "SPEED", "LEVEL", "SPREAD", "UNKNOWN",
    ),
    "TRANSFER": ("FORCE", "LOAD", "ARM"),
    "TOLD": ("CONFIDENCE",),
    "GRIP": ("HELD", "REQUIRED", "ENVELOPE", "QUIET", "SLOT", "PRESENT", "FILLED", "MEDIAN", "ELAPSED",
             "ADJUSTMENT", "PROVEN", "PROVEN_TIME"),
    "LARGEST": WINDOW_SLOTS, "ORDERED": WINDOW_SLOTS,
}  # fmt: skip
"""RULE: settings; LOWEST, HIGHEST: believable ranges of the channels;
REPEATED, REPEATED_FORCE: the mechanical channels last seen; WATCH: of the watchdog;
CONFIRMED: the load that counts (:mod:`vegrip.grip.confirmed_load`); DEMAND: what the finger needs;
ASKED: margin and quantile that this state is judged with; SHARED: how
the fingers of a grasp share friction, and what this one has of it (version of the belief, own evidence of the
present loading, mean and variance of ln mu before the state, slip flag and
slip speed as they are sensed, LEVEL, SPREAD, UNKNOWN: what is stated of friction beside its belief);
TRANSFER: what a contact met in its middle began with; TOLD: of the slip margin that is told; GRIP: held and
required force, envelope of the need, running median of it, time since a fault began, change of the force by
the last command, lowest median of late; LARGEST: the median's slots; ORDERED: scratch.
"""

WHOLES: Sections = {
    "SETUP": (
        "STATE_ID", "COMMAND_ID", "SENDER_TIME", "FINGER", "FINGERS", "THUMB", "RECOVER_AFTER", "LIFETIME",
        "EXPIRES", "RENEWAL", "SHARES", "LEADS",
        "CONTACT1_ID", "CONTACT2_ID", "MARGIN_ID", "REPORT_PERIOD",
    ),
    "LINE": ("LAST", "STAMP", "LOST"),
    "INPUT": (
        "CONDITION", "GOOD", "DOUBTFUL", "LOST", "SEEN", "PRESENT", "USABLE", "HEARD", "IS_HEARD", "CORRUPT",
        "IS_CORRUPT", "SEQ", "STAMP", "IS_KNOWN", "LEAPS", "STILL_SINCE", "FORCE_STILL_SINCE", "RUN", "COUNT",
        "QUICKEST", "TRAVEL_SINCE",
    ),
    "FAULTS": len(Condition),
    "NEED": ("IN_CONTACT", "SLIPPING", "TRUSTED", "BELIEVED"),
    "TURN": (
        "SEEN", "HAS_MARGIN", "TRANSFER_SINCE", "IN_TRANSFER", "STARTED", "COMMANDED", "ASKED", "SEQ",
        "REASON", "SLOTS", "NEXT_SLOT", "USED", "TOLD", "REPORT_DUE", "NOTED", "FETCHED", "GIVEN_REASON",
        "LEARNED", "LED", "CONTACT_DUE", "HEALTH_DUE", "REPORTS", "REPORTED",
    ),
}  # fmt: skip
"""SETUP: settings; LINE: counter of the frames; INPUT: of the watchdog (LOST, SEEN, PRESENT: sets of
channels, bit by bit); FAULTS: counts by condition; NEED: of the demand, and whether the state is believed;
TURN: of the control: times (CONTACT_DUE: of the next report of contact and margin, 0: of the first one, which
is a message; HEALTH_DUE: of the health; REPORT_DUE: the first of both), counters, states noted in the history
and fetched from it, the reason in the last command (REASON is that of the required force).
"""


NODE_REALS = {
    "BASELINE": ("FORCE", "FRICTION", "SAFETY", "RADIUS", "POWER", "EXPONENT"),
    "OWN": ("BASE", "STEP", "FORCE", "SHARE"),
}
"""Of a finger in a node: settings of a baseline policy (:mod:`vegrip.grip.policies.baselines`); what a policy
or a share in Python is told (force to start from, time since it was asked) and has answered [N]."""

NODE_WHOLES = {"CHOICE": ("POLICY", "ASKS", "SHARE", "REASON", "FORGOTTEN")}
"""CHOICE: which policy rules, whether it asks for the least force, whether the share of the grasp comes from
Python, reason of a policy in Python, and how often it has to forget the past."""

PARTS = ("COUNTER", "STAMP", "EXPECTED", "INCOMPLETE", "CLIPPED_FORCE", "CLIPPED_ADJUSTMENT")
"""Of a state that comes in several frames, where states do: counter and arrival of its first one, number of
the frame that must come next (0: of a new state), states that were begun and not finished; and how many
commands were beyond what their frame carries."""


@dataclass(frozen=True)
class FingerLayout(SampleLayout):
    """Sizes and places for one finger.

    Args:
        filter: of the filter's numbers.
        late: samples that the estimator can go back.
        history: states that are kept for others; 0 keeps none.
        is_shared: whether it is one of a node: fingers can share friction and lead their loads, and
            policies can be chosen.
        part_bytes: values of all frames of a state, where several make one.

    """

    history: int = 0
    is_shared: bool = False
    part_bytes: int = 0

    def real_sections(self) -> Iterator[tuple[str, tuple[str, ...], int]]:
        """Yield name, names within and length of the sections of real numbers."""
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
        if self.part_bytes:
            yield "PARTS", PARTS, len(PARTS)
            yield "PART_BYTES", (), self.part_bytes

    def constants(self) -> str:
        """Return the places, and the codes of conditions and reasons, as program text."""
        return "\n".join([
            super().constants(),
            *(f"CONDITION_{one.name} = {one.value}" for one in Condition),
            *(f"REASON_{one.name} = {one.value}" for one in Reason),
            f"HISTORY_STATES = {self.history}",
        ])  # fmt: skip
