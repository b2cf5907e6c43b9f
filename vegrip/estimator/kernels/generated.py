"""What the kernels find in a generated module: the model, the gauge, sizes and places.

The kernels are ordinary files, to be read, linted and typed; nothing imports them. Their text, without the
imports from vegrip, is appended to the generated module of a model, where these names have that model's
values (:meth:`vegrip.estimator.layout.Layout.names`). This file declares them; it is written by
``python -m tools.write_declarations``.
"""

from vegrip.contact.limit_surface.fast import gauge, radius_gradient_towards, torsion_gradient
from vegrip.model.generated import Floats, advance, readout

__all__ = ["Floats", "advance", "gauge", "radius_gradient_towards", "readout", "torsion_gradient"]

N: int
M: int
NS: int
N_LEARNED: int
N_CONSIDERED: int
DELTA: int
SPEED: int
EFFECTS: int
LEARNED_FROM: int
OFFSET: int
BIAS: int
MU_PLACE: int
CONSIDERED_MU: int
CHANNELS: int
CHANNEL_SIZE: int
CHANNEL_DISPLACEMENT: int
CHANNEL_FORCE: int
CHANNEL_RADIUS: int
CH_STREAK: int
CH_REJECTED: int
CH_AGE: int
CH_USED: int
REGIMES: int
CELL_SIZE: int
CELL_WEIGHT: int
CELL_MEAN: int
CELL_NIS: int
PART_SIZE: int
PART_AVERAGE: int
PART_LAST: int
PART_LEAST: int
PART_BEFORE: int
PART_BLOCK: int
PART_LOST: int
REGIME_AIR: float
REGIME_LOADING: float
REGIME_HOLD: float
REGIME_UNLOADING: float
REGIME_DEEP_LOADING: float
REGIME_FAST_LOADING: float
REGIME_DEEP_HOLD: float
REGIME_LATE_HOLD: float
REGIME_DEEP_UNLOADING: float
REGIME_FAST_UNLOADING: float
REGIME_SLIDING: float
REGIME_JERK: float
LEARNED: tuple[int, ...]
LEARNED_LOG: tuple[bool, ...]
CONSIDERED: tuple[int, ...]
CONSIDERED_LOG: tuple[bool, ...]
STATE_LOW: tuple[int, ...]
STATE_HIGH: tuple[int, ...]
STATE_SHARE: tuple[int, ...]
KEPT: tuple[bool, ...]
FELT: tuple[bool, ...]
Y0: int
Y1: int
P0: int
P1: int
VALUES0: int
EXOGENOUS0: int
PRIOR0: int
LOW0: int
HIGH0: int
DRIFT0: int
SET_ACCELERATION: int
SET_R_FORCE: int
SET_R_DISPLACEMENT: int
SET_R_RADIUS: int
SET_S_TANGENTIAL: int
SET_S_TORQUE: int
SET_LONGEST_GAP: int
SET_TIP_RADIUS: int
SET_DEPTH: int
SET_QUANTILE: int
SET_HORIZON: int
SET_HOLD: int
SET_SCATTER: int
SET_MU_DRIFT: int
SET_REGRASP: int
SET_MU_PRIOR_VAR: int
SET_HEALTH_TIME: int
SET_LEARNING_REST: int
FRI_LN_MU: int
FRI_VAR: int
FRI_BASE_LN: int
FRI_BASE_VAR: int
FRI_PEAK: int
FRI_BEST: int
FRI_SLIDING: int
FRI_SMOOTH: int
FRI_TOUCHING: int
FRI_EVENTS: int
FRI_PROVEN: int
FRI_HELD_TIME: int
FRI_HELD_LEAST: int
FRI_SLIDE_COUNT: int
FRI_SLIDE_MEAN: int
FRI_UNCONFIRMED: int
FRI_SCATTER_VAR: int
CONSIDER0: int
REP_FORCE: int
REP_FORCE_STD: int
REP_RADIUS: int
REP_RADIUS_STD: int
REP_EXPONENT: int
REP_EXPONENT_STD: int
REP_MU: int
REP_MU_STD: int
REP_LIMIT_FORCE: int
REP_LIMIT_FORCE_STD: int
REP_LIMIT_TORQUE: int
REP_LIMIT_TORQUE_STD: int
REP_LIMIT_RADIUS: int
REP_LIMIT_RADIUS_STD: int
REP_GAUGE: int
REP_GAUGE_REL: int
REP_GAUGE_ABS: int
REP_DEPTH_NOW: int
REP_DEPTH_STD: int
REP_CONTACT: int
REP_SOUND: int
REP_RADIUS_SOUND: int
CHANNEL0: int
HEALTH0: int
MODE0: int
MODE1: int
MODE_ZERO_KNOWN: int
MODE_BLIND: int
MODE_HEALTH_DECAY: int
MODE_REGIME: int
MODE_REST: int
MODE_CELL: int
MODE_SINCE_JERK: int
MODE_PERIOD: int
MODE_CAUTION: int
MODE_CONTRADICTED: int
MODE_UNEXPLAINED: int
MODE_CORNER: int
MODE_SLOPE: int
MODE_TOLERATED: int
MODE_LOST: int
MODE_AGREED: int
MODE_TOUCH: int
MODE_FELT: int
MODE_FREE_DEPTH: int
MODE_ZERO_MEAN: int
MODE_ZERO_VAR: int
MODE_RADIUS_CONTRADICTED: int
MODE_BEND: int
MODE_MET: int
MOTION_POSITION: int
MOTION_SPEED: int
MOTION_VAR_POSITION: int
MOTION_COV: int
MOTION_VAR_SPEED: int
MOTION_RESTLESS: int
START0: int
COUNT_RESTARTS: int
COUNT_OVERFLOWS: int
BEND_SUM0: int
RATIO0: int
RATIO_COUNT: int
RATIO_PLACE: int
PART0: int
OLD0: int
KEPT_Y0: int
KEPT_P0: int
F0: int
B0: int
H0: int
H1: int
G0: int
K0: int
BEND0: int
NEXT0: int
TRIAL0: int
L0: int
D_FORCE0: int
D_RADIUS0: int
D_EXPONENT0: int
D_FRICTION0: int
D_DELTA0: int
TRY0: int
MID0: int
DISPLACEMENT_STREAK: int
DISPLACEMENT_AGE: int
FORCE_STREAK: int
