"""What the control's kernels find in a generated module, beside each other: places, codes, frames.

This file declares them for those who read and check the kernels; their values are of a model and its DBC
(:mod:`vegrip.grip.layout`, :mod:`vegrip.transport.codec.kernel_text`).
"""

import numpy as np
from numpy.typing import NDArray

from vegrip.estimator.kernels.generated import (
    CH_USED,
    CHANNEL0,
    CHANNEL_DISPLACEMENT,
    CHANNEL_FORCE,
    CHANNEL_RADIUS,
    CHANNEL_SIZE,
    EXOGENOUS0,
    FRI_BASE_LN,
    FRI_BASE_VAR,
    FRI_LN_MU,
    FRI_VAR,
    REP_CONTACT,
    REP_DEPTH_NOW,
    REP_DEPTH_STD,
    REP_EXPONENT,
    REP_EXPONENT_STD,
    REP_FORCE,
    REP_FORCE_STD,
    REP_GAUGE,
    REP_GAUGE_ABS,
    REP_GAUGE_REL,
    REP_LIMIT_FORCE,
    REP_LIMIT_FORCE_STD,
    REP_LIMIT_RADIUS,
    REP_LIMIT_RADIUS_STD,
    REP_LIMIT_TORQUE,
    REP_LIMIT_TORQUE_STD,
    REP_MU,
    REP_MU_STD,
    REP_RADIUS,
    REP_RADIUS_SOUND,
    REP_RADIUS_STD,
    REP_SOUND,
    SET_LONGEST_GAP,
    SET_QUANTILE,
    SET_S_TANGENTIAL,
    SET_S_TORQUE,
    Floats,
)

__all__ = [
    "CHANNEL0",
    "CHANNEL_DISPLACEMENT",
    "CHANNEL_FORCE",
    "CHANNEL_RADIUS",
    "CHANNEL_SIZE",
    "CH_USED",
    "EXOGENOUS0",
    "FRI_BASE_LN",
    "FRI_BASE_VAR",
    "FRI_LN_MU",
    "FRI_VAR",
    "REP_CONTACT",
    "REP_DEPTH_NOW",
    "REP_DEPTH_STD",
    "REP_EXPONENT",
    "REP_EXPONENT_STD",
    "REP_FORCE",
    "REP_FORCE_STD",
    "REP_GAUGE",
    "REP_GAUGE_ABS",
    "REP_GAUGE_REL",
    "REP_LIMIT_FORCE",
    "REP_LIMIT_FORCE_STD",
    "REP_LIMIT_RADIUS",
    "REP_LIMIT_RADIUS_STD",
    "REP_LIMIT_TORQUE",
    "REP_LIMIT_TORQUE_STD",
    "REP_MU",
    "REP_MU_STD",
    "REP_RADIUS",
    "REP_RADIUS_SOUND",
    "REP_RADIUS_STD",
    "REP_SOUND",
    "SET_LONGEST_GAP",
    "SET_QUANTILE",
    "SET_S_TANGENTIAL",
    "SET_S_TORQUE",
    "Floats",
]  # fmt: skip

Wholes = NDArray[np.int64]
Bytes = NDArray[np.uint8]

ABSENT_BYTES: NDArray[np.int64]
ADJUSTMENT_HIGH: int
ADJUSTMENT_LOW: int
ADJUSTMENT_SCALE: float
ASKED_MARGIN: int
ASKED_QUANTILE: int
COMMAND_LENGTH: int
CONDITION_CORRUPT: int
CONDITION_DEGRADED: int
CONDITION_FROZEN: int
CONDITION_MISSING: int
CONDITION_OK: int
CONDITION_OUT_OF_RANGE: int
CONDITION_REPLAYED: int
CONDITION_STALE: int
CONFIRMED0: int
CONTACT_LENGTH: int
DEMAND_BOUND: int
DEMAND_LEAST: int
DEMAND_LOAD: int
DEMAND_TORQUE: int
FAULTS0: int
FORCE_HIGH: int
FORCE_LOW: int
FORCE_SCALE: float
GRIP_ADJUSTMENT: int
GRIP_ELAPSED: int
GRIP_ENVELOPE: int
GRIP_FILLED: int
GRIP_HELD: int
GRIP_MEDIAN: int
GRIP_PRESENT: int
GRIP_PROVEN: int
GRIP_PROVEN_TIME: int
GRIP_QUIET: int
GRIP_REQUIRED: int
GRIP_SLOT: int
HIGHEST0: int
HISTORY0: int
HISTORY_SEQ0: int
HISTORY_STAMP0: int
HISTORY_STATES: int
INPUT_CONDITION: int
INPUT_CORRUPT: int
INPUT_COUNT: int
INPUT_DOUBTFUL: int
INPUT_FORCE_STILL_SINCE: int
INPUT_GOOD: int
INPUT_HEARD: int
INPUT_IS_CORRUPT: int
INPUT_IS_HEARD: int
INPUT_IS_KNOWN: int
INPUT_LEAPS: int
INPUT_LOST: int
INPUT_PRESENT: int
INPUT_QUICKEST: int
INPUT_RUN: int
INPUT_SEEN: int
INPUT_SEQ: int
INPUT_STAMP: int
INPUT_STILL_SINCE: int
INPUT_TRAVEL_SINCE: int
INPUT_USABLE: int
LARGEST0: int
LASTING_SIZE: int
LATER0: int
LATE_SAMPLES: int
LEAST_SLIDING_SPEED: float
LINE_LAST: int
LINE_LOST: int
LINE_STAMP: int
LOADING: int
LOWEST0: int
MARGIN_LENGTH: int
MEASURED: int
MECHANICAL: int
MU_LEARNED: bool
NEED_IN_CONTACT: int
NEED_SLIPPING: int
NEED_TRUSTED: int
NEWS_SEQ: int
NEWS_STAMP: int
ORDERED0: int
PARTS_CLIPPED_ADJUSTMENT: int
PARTS_CLIPPED_FORCE: int
PARTS_COUNTER: int
PARTS_EXPECTED: int
PARTS_INCOMPLETE: int
PARTS_STAMP: int
PART_BYTES0: int
PART_LENGTH: int
PART_OFFSETS: NDArray[np.int64]
PART_PAYLOAD: int
PART_VERSION: int
REASON_FAIL_SAFE: int
REASON_FORECAST: int
REASON_HOLD: int
REASON_INPUT_HOLD: int
REASON_LOWER: int
REASON_MAX_LIMIT: int
REASON_MIN_LIMIT: int
REASON_RAISE: int
REASON_RATE_LIMIT: int
REASON_SLIP: int
REASON_UNTRUSTED: int
REPEATED0: int
REPEATED_FORCE0: int
REWIND0: int
REWIND_BEFORE0: int
REWIND_BEGUN0: int
REWIND_STAMP0: int
REWIND_STATE0: int
RULE_DEAD_BAND: int
RULE_DOUBT_AFTER: int
RULE_FORCE_FROZEN_AFTER: int
RULE_FROZEN_AFTER: int
RULE_FROZEN_CHANCE: int
RULE_HOLD_TIME: int
RULE_LIFETIME: int
RULE_LOWER_RATE: int
RULE_MAX_FORCE: int
RULE_MIN_FORCE: int
RULE_PROVEN_TIME: int
RULE_QUANTILE: int
RULE_RAISE_RATE: int
RULE_RAMP_RATE: int
RULE_RELEASE_TIME: int
RULE_SAFE_FORCE: int
RULE_SETTLE_TIME: int
RULE_SLIP_GROWTH: int
RULE_STUCK_TRAVEL: int
RULE_TIME_OUT: int
RULE_USUAL_TIME: int
RULE_WANTED_MARGIN: int
SAMPLE_BACKWARDS: int
SAMPLE_BEGUN: int
SAMPLE_INFORMED: int
SAMPLE_IS_INFORMED: int
SAMPLE_REFUSED: int
SAMPLE_RESUMED: int
SAMPLE_FOLLOWED: int
SAMPLE_KEPT: int
SAMPLE_LATE: int
SAMPLE_REWIND_NEXT: int
NEED_BELIEVED: int
BASELINE_EXPONENT: int
BASELINE_FORCE: int
BASELINE_FRICTION: int
BASELINE_POWER: int
BASELINE_RADIUS: int
BASELINE_SAFETY: int
OWN_BASE: int
OWN_FORCE: int
OWN_SHARE: int
OWN_STEP: int
CHOICE_ASKS: int
CHOICE_FORGOTTEN: int
CHOICE_POLICY: int
CHOICE_REASON: int
CHOICE_SHARE: int
SAMPLE_SEQ: int
SAMPLE_SHOWN: int
SAMPLE_STAMP: int
SAMPLE_TRUSTED: int
SETUP_COMMAND_ID: int
SETUP_CONTACT1_ID: int
SETUP_CONTACT2_ID: int
SETUP_EXPIRES: int
SETUP_FINGER: int
SETUP_FINGERS: int
SETUP_GAP: int
SETUP_LEADS: int
SETUP_MARGIN_ID: int
SETUP_RECOVERY: int
SETUP_RECOVER_AFTER: int
SETUP_RENEWAL: int
SETUP_REPORT_PERIOD: int
SETUP_SENDER_TIME: int
SETUP_SHARES: int
SETUP_STATE_ID: int
SETUP_THUMB: int
SHARED_BEFORE: int
SHARED_BEFORE_VAR: int
SHARED_FLAG: int
SHARED_KNOWN_QUANTILE: int
SHARED_LEVEL: int
SHARED_LOAD_NOISE: int
SHARED_SEEN: int
SHARED_SITE: int
SHARED_SITE_WEIGHTED: int
SHARED_SPEED: int
SHARED_SPREAD: int
SHARED_UNKNOWN: int
SHARED_WIDEST: int
SHORT_COMMAND_LENGTH: int
SLIDES: float
STATE0: int
STATE_CONTACT_RADIUS: int
STATE_DISPLACEMENT: int
STATE_LENGTH: int
STATE_NORMAL_FORCE: int
STATE_PARTS: int
STATE_SLIP: int
STATE_SLIP_SPEED: int
STATE_TANGENTIAL_FORCE_X: int
STATE_TANGENTIAL_FORCE_Y: int
STATE_TEMPERATURE: int
STATE_TORQUE_Z: int
SUFFICIENT: int
TAKEN_BOUND: int
TAKEN_LOAD: int
TAKEN_TORQUE: int
TOLD_CONFIDENCE: int
TRANSFER_ARM: int
TRANSFER_FORCE: int
TRANSFER_LOAD: int
TURN_ASKED: int
TURN_COMMANDED: int
TURN_CONTACT_DUE: int
TURN_FETCHED: int
TURN_GIVEN_REASON: int
TURN_HAS_MARGIN: int
TURN_HEALTH_DUE: int
TURN_IN_TRANSFER: int
TURN_LEARNED: int
TURN_LED: int
TURN_NEXT_SLOT: int
TURN_NOTED: int
TURN_REASON: int
TURN_REPORTED: int
TURN_REPORTS: int
TURN_REPORT_DUE: int
TURN_SEEN: int
TURN_SEQ: int
TURN_SLOTS: int
TURN_STARTED: int
TURN_TOLD: int
TURN_TRANSFER_SINCE: int
TURN_USED: int
USUAL_SLOTS: int
WATCH_CHANGE: int
WATCH_LEVEL: int
WATCH_NOISE_LAST: int
WATCH_REPEATS: int
WATCH_REPEAT_LIMIT: int
WATCH_TURNS: int
WIRE_VERSION: int


def counter_of_state(data: Bytes) -> int:
    """Counter of the sender."""
    raise NotImplementedError


def version_of_state(data: Bytes) -> int:
    """Version of the message set."""
    raise NotImplementedError


def time_of_state(data: Bytes) -> int:
    """Time of the sender [us], 32 bits."""
    raise NotImplementedError


def values_mean_something(data: Bytes) -> bool:
    """Whether no value is infinite."""
    raise NotImplementedError


def unpack_state(f: Floats, data: Bytes) -> None:
    """Take the values of a state, in SI units."""
    raise NotImplementedError


def pack_command(
    data: Bytes, seq: int, stamp: int, force: float, adjustment: float, reason: int, expires: int
) -> None:
    """Write a command, but for its checksum; ``expires`` as it stands in the frame."""
    raise NotImplementedError


def pack_margin(
    data: Bytes,
    seq: int,
    stamp: int,
    margin_valid: int,
    margin: float,
    margin_std: float,
    margin_age: float,
    lower_bound: float,
    confidence: float,
    force_reserve: float,
    time_to_slip: float,
    earliest_slip: float,
) -> None:
    """Write a slip margin, but for its checksum; flags are 0 or 1."""
    raise NotImplementedError


def pack_contact1(
    data: Bytes,
    seq: int,
    stamp: int,
    in_contact: int,
    indentation_valid: int,
    normal_force_valid: int,
    contact_radius_valid: int,
    pressure_exponent_valid: int,
    indentation: float,
    indentation_std: float,
    age: float,
    normal_force: float,
    normal_force_std: float,
    contact_radius: float,
    contact_radius_std: float,
    pressure_exponent: float,
    pressure_exponent_std: float,
    channels: int,
) -> None:
    """Write the first frame of a contact, but for its checksum."""
    raise NotImplementedError


def pack_contact2(
    data: Bytes,
    seq: int,
    stamp: int,
    friction_coefficient_valid: int,
    limit_force_valid: int,
    limit_torque_valid: int,
    limit_radius_valid: int,
    friction_coefficient: float,
    friction_coefficient_std: float,
    age: float,
    limit_force: float,
    limit_force_std: float,
    limit_torque: float,
    limit_torque_std: float,
    limit_radius: float,
    limit_radius_std: float,
) -> None:
    """Write the second frame of a contact, but for its checksum."""
    raise NotImplementedError


def counter_of_part(data: Bytes) -> int:
    """Counter of the sender, of a classic frame."""
    raise NotImplementedError


def version_of_part(data: Bytes) -> int:
    """Version of the message set, of a classic frame."""
    raise NotImplementedError


def is_last_part(data: Bytes) -> bool:
    """Whether no further part of the state comes."""
    raise NotImplementedError


def part_means_something(data: Bytes, part: int) -> bool:
    """Whether every raw value of a part has a meaning."""
    raise NotImplementedError


def unpack_parts(f: Floats, t: Wholes) -> None:
    """Take the values of the kept parts of a state, in SI units."""
    raise NotImplementedError


def pack_short_command(
    data: Bytes, counter: int, force: int, adjustment: int, reason: int, expires: int
) -> None:
    """Write a classic command of raw values, but for its checksum."""
    raise NotImplementedError
