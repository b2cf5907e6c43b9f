"""What the kernels of a trial find in the generated module: places in ``h`` and sizes of the hand.

Nothing imports these files at run time; their text is appended to that of the estimator
(:meth:`vegrip.trials.layout.TrialLayout.constants` gives the values).
"""

from vegrip.estimator.kernels.generated import (
    CH_USED,
    CHANNEL0,
    FRI_BASE_LN,
    FRI_BASE_VAR,
    FRI_LN_MU,
    FRI_VAR,
    REP_CONTACT,
    REP_FORCE,
    REP_FORCE_STD,
    REP_RADIUS,
    REP_SOUND,
    SET_S_TANGENTIAL,
    SET_S_TORQUE,
    Floats,
)

__all__ = [
    "CHANNEL0",
    "CH_USED",
    "FRI_BASE_LN",
    "FRI_BASE_VAR",
    "FRI_LN_MU",
    "FRI_VAR",
    "REP_CONTACT",
    "REP_FORCE",
    "REP_FORCE_STD",
    "REP_RADIUS",
    "REP_SOUND",
    "SET_S_TANGENTIAL",
    "SET_S_TORQUE",
    "Floats",
]

H_STEP: int
H_TICKS: int
H_Z: int
H_DROPPED: int
H_SLIPS: int
H_EVENT_OPEN: int
H_COUNTED: int
H_EVENT_REST: int
H_MICRO: int
H_MICROS: int
H_FORCE_LIMIT: int
H_FORCE_RATE: int
H_BANDWIDTH: int
H_DRIVE_SPEED: int
H_STICTION: int
H_INITIAL_FORCE: int
H_CLOSE_TIME: int
H_LIFT_TIME: int
H_MASS: int
H_INERTIA: int
H_GRAVITY: int
H_FAR_LOST: int
H_ANGLE_LOST: int
H_SAMPLE_TIME: int
H_SLIP_SENSOR: int
H_SLIP_THRESHOLD: int
H_SLIP_DELAY: int
H_D0: int
H_POWER: int
H_FORCE_SCALE: int
H_TIP_RADIUS: int
H_FINAL: int
H_INSTANT: int
H_PAST: int
H_SUM: int
H_BEFORE: int
H_FORCE: int
H_DEPTH: int
H_REFERENCE: int
H_RADIUS: int
H_K: int
H_MU: int
H_MU_DRY: int
H_STIFFNESS: int
H_DAMPING: int
H_DRIVE: int
H_TARGET: int
H_COMMAND: int
H_SLIDING: int
H_EVENT_SLID: int
H_BRANCHES: int
H_BRANCH_DECAY: int
H_BRANCH_SHARE: int
H_STEPS: int
H_POSE: int
H_START: int
H_PLACE: int
H_WRENCH: int
H_SLIP: int
H_READING: int
H_FLAGS: int
H_SPEEDS: int
H_LOAD: int
H_REACH: int
H_AREA: int
H_COSINE: int
H_SINE: int
H_BRISTLE: int
H_EXPONENT_TABLE: int
H_RING_TABLE: int
G_POLICY: int
G_MARGIN: int
G_QUANTILE: int
G_QUANTILE_KNOWN: int
G_DEAD_BAND: int
G_RECOVERY: int
G_RELEASE_TIME: int
G_SETTLE_TIME: int
G_SINCE_LED: int
G_SLOT: int
G_SLIP_GROWTH: int
G_MIN_FORCE: int
G_MAX_FORCE: int
G_RAISE_RATE: int
G_LOWER_RATE: int
G_LIFETIME: int
G_FAIL_FORCE: int
G_FAIL_HOLD: int
G_FAIL_RAMP: int
G_CONSTANT: int
G_CONE: int
G_CONFIRMED: int
G_LONGEST_GAP: int
G_LEARNS: int
G_KNOWN: int
G_PROVEN_TIME: int
G_BELIEVED: int
G_BELIEVED_VAR: int
G_COMMAND: int
G_REQUIRED: int
G_FAULTY: int
G_SAMPLES: int
G_INFORMED: int
G_TRANSFER: int
G_FIRST_FORCE: int
G_FIRST_LOAD: int
G_FIRST_ARM: int
G_SEEN: int
G_SITE: int
G_SITE_WEIGHTED: int
G_ENVELOPE: int
G_QUIET: int
G_SLOTS_USED: int
G_SLOT_FILLED: int
G_SLOT_PRESENT: int
G_SLOT_MEDIAN: int
G_PROVEN: int
G_ELASTIC: int
G_SLOTS: int
G_SORTED: int
HAND_RATIO: float
HAND_FRESH: float
HAND_FINGERS: int
HAND_RINGS: int
HAND_SPOKES: int
HAND_BRANCHES: int
HAND_TABLE: int
HAND_FLAGS: int
SLOT_COUNT: int
ROW: int
ROW_FINGER: int
