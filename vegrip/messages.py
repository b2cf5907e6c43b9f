"""The messages of vegrip: what goes in, what comes out, frozen and stamped.

Rules shared by all of them:

* SI units; temperature in degrees Celsius; compression positive; contact frame right-handed with z the
  outward normal of the fingertip.
* ``stamp`` is an integer number of nanoseconds of a monotonic clock, ``seq`` a counter that the sender
  raises by one with every message of that kind and finger (it wraps on the wire, never here).
* A quantity that was not measured is NaN; it is never zero and never the last value.
* Every estimate leaves as :class:`Estimate`: value, standard deviation, validity and age.
"""

import math
from collections import namedtuple
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from enum import IntEnum, IntFlag
from typing import Any, ClassVar, Final, TypeVar

from vegrip.displayed import Displayed

NAN: Final = math.nan
VERSION: Final = 1
"""Version of the message set. Raised when a field is removed, renamed or changes its meaning."""

USUAL_FINGERS: Final = ("thumb", "index", "middle", "ring", "little")
"""In the order of their numbers on the bus, where nothing else is said."""


class Lifecycle(IntEnum):
    """States of a managed node (ROS 2); the values are vegrip's own, NMT is mapped by ``vegrip.canopen``."""

    UNCONFIGURED = 0
    INACTIVE = 1
    ACTIVE = 2
    FINALIZED = 3


class Channel(IntFlag):
    """Which measurements an estimate rests on."""

    NONE = 0
    FORCE = 1  # normal force
    POSITION = 2  # displacement
    RADIUS = 4  # contact radius (camera, tactile array)
    TANGENTIAL = 8  # tangential force (both components)
    TORQUE = 16  # torque about the contact normal
    SLIP = 32  # slip flag


class Condition(IntEnum):
    """What is wrong with a finger's input; of several the one with the largest number is reported."""

    OK = 0
    DEGRADED = 1  # some channel missing, the rest is good
    STALE = 2  # no state within the time-out
    MISSING = 3  # no state ever, or no usable channel
    OUT_OF_RANGE = 4
    FROZEN = 5  # counter runs, values do not
    REPLAYED = 6  # counter or stamp runs backwards or stands still
    CORRUPT = 7  # checksum or format


class GraspPhase(IntEnum):
    """How far a grasp or a release is that was asked for."""

    NONE = 0  # nothing was asked for: the hand grips by itself
    CLOSING = 1
    HELD = 2  # it is made: enough fingers touch, and the margin is that of the goal
    MISSED = 3  # too few fingers touch: nothing is there, or it is lost
    WEAK = 4  # it is touched, but the margin or the force of the goal is not reached
    RELEASING = 5
    RELEASED = 6


class Reason(IntEnum):
    """Why a force command has the value it has; the last stage that changed it wins."""

    HOLD = 0  # the wanted margin is met
    RAISE = 1  # more force for the wanted margin
    LOWER = 2  # less force suffices
    SLIP = 3  # slip was felt
    FORECAST = 4  # the relaxing contact would slip within the horizon
    RATE_LIMIT = 5
    MIN_LIMIT = 6
    MAX_LIMIT = 7
    INPUT_HOLD = 8  # bad input: the last safe command is held
    FAIL_SAFE = 9  # bad input for long: ramp to the fail-safe grip
    UNTRUSTED = 10  # the estimate is not valid: never below the last safe command
    INACTIVE = 11  # the node is not active: no control


@dataclass(frozen=True, slots=True)
class Estimate:
    """One estimated quantity."""

    value: float = NAN
    std: float = math.inf
    valid: bool = False
    age: float = math.inf  # [s] since the last measurement that informed it


UNKNOWN: Final = Estimate()

Row = TypeVar("Row")


def row(cls: type[Row]) -> type[Row]:
    """Let the instances of a frozen dataclass be tuples, each made in a fifth of the time.

    For what comes and goes a thousand times a second. ``dataclasses.replace`` and ``fields`` work as before.
    """
    defaults = [one.default for one in fields(cls) if one.default is not MISSING]  # type: ignore[arg-type]
    base = namedtuple(cls.__name__, cls.__dataclass_fields__, defaults=defaults)  # type: ignore[attr-defined,misc]
    kept = ("__doc__", "__module__", "__qualname__", "__annotations__", "__dataclass_fields__")
    made: Any = type(cls.__name__, (base,), {"__slots__": (), **{name: getattr(cls, name) for name in kept}})
    return made  # type: ignore[no-any-return]


make_row: Final[Any] = tuple.__new__
"""``make_row(ForceCommand, values)`` makes a row of all its values; keywords take as long again."""


@row
@dataclass(frozen=True)
class FingertipState:
    """What one fingertip senses at one instant. Any subset of the quantities may be NaN."""

    stamp: int  # [ns]
    finger: str
    seq: int
    normal_force: float = NAN  # [N] compression positive
    tangential_force_x: float = NAN  # [N]
    tangential_force_y: float = NAN  # [N]
    torque_z: float = NAN  # [N m]
    displacement: float = NAN  # [m] indentation direction, zero at first touch
    temperature: float = NAN  # [degrees Celsius]
    slip: float = NAN  # 1 sliding, 0 sticking, NaN not sensed
    slip_speed: float = NAN  # [m/s]
    contact_radius: float = NAN  # [m]


@dataclass(frozen=True, slots=True, repr=False)
class ContactEstimate(Displayed):
    """The contact as the estimator sees it."""

    _display: ClassVar[str] = "contact"

    stamp: int
    finger: str
    seq: int
    in_contact: bool = False
    channels: Channel = Channel.NONE
    indentation: Estimate = UNKNOWN  # [m]
    normal_force: Estimate = UNKNOWN  # [N]
    contact_radius: Estimate = UNKNOWN  # [m]
    pressure_exponent: Estimate = UNKNOWN  # [-]
    friction_coefficient: Estimate = UNKNOWN  # [-]
    limit_force: Estimate = UNKNOWN  # [N] mu N
    limit_torque: Estimate = UNKNOWN  # [N m] pure torsion
    limit_radius: Estimate = UNKNOWN  # [N] distance to the limit surface along the present load


@dataclass(frozen=True, slots=True, repr=False)
class SlipMargin(Displayed):
    """How far the contact is from slipping, now and in time."""

    _display: ClassVar[str] = "contact"

    stamp: int
    finger: str
    seq: int
    margin: Estimate = UNKNOWN  # [-] 1 - |load| / limit_radius, 0 = on the limit surface
    lower_bound: float = NAN  # [-] of the margin, at `confidence`
    confidence: float = NAN  # [-] one-sided probability, e.g. 0.95
    force_reserve: float = NAN  # [N] normal force that could be lost before slip, at `confidence`
    time_to_slip: float = NAN  # [s] under the present hold; inf = never
    earliest_slip: float = NAN  # [s] its lower bound at `confidence`


@row
@dataclass(frozen=True)
class ForceCommand:
    """The grip force a finger shall apply."""

    stamp: int
    finger: str
    seq: int
    normal_force: float  # [N]
    adjustment: float  # [N] against the previous command
    reason: Reason
    expires: int  # [ns] the receiver must not use it later than this


PROBED = "probed"
"""Force is lowered slowly on purpose, to learn friction: see :attr:`ModelHealth.friction`."""
KNOWN = "known"
"""No more is held than the friction that was learned asks for."""
LIMIT_NEAR = "near"
"""A load half as large again, or one that grows on, needs more than ``limits.max_force``."""
LIMIT_REACHED = "reached"
"""More is needed than ``limits.max_force``: the margin is not kept, see :attr:`ModelHealth.limit`."""
BEYOND_FIT = "beyond"
"""The channel is beyond the range over which the model was fitted: see :attr:`ModelHealth.regime`."""


@dataclass(frozen=True, slots=True)
class ModelHealth:
    """Whether the model still explains what is measured."""

    stamp: int
    finger: str
    seq: int
    condition: Condition = Condition.MISSING
    nis: float = NAN  # [-] normalised innovation squared, mean per measurement; 1 = consistent
    consistent: bool = False  # nis inside its band
    channel: str = ""  # the channel that fails most, "" = none
    regime: str = ""  # and where: "loading", "hold", "unloading", "air", ..., BEYOND_FIT where none fails
    suspect: str = ""  # leading missing effect, "" = not known
    rejected: int = 0  # measurements refused by the outlier gate since activation
    friction: str = ""  # what the grip assumes: PROBED, KNOWN, "" = what is usual
    limit: str = ""  # whether the largest force suffices: LIMIT_NEAR, LIMIT_REACHED, "" = it does


@dataclass(frozen=True, slots=True)
class LearnedParameter:
    """What the estimator has learned of one parameter of its model."""

    stamp: int
    finger: str
    seq: int
    symbol: str = ""  # of the model, which knows the unit
    raw: Estimate = UNKNOWN  # as the filter has it now
    filtered: Estimate = UNKNOWN  # smoothed over excited contact; valid with hysteresis
    excited: float = NAN  # [s] of motion in contact that went into it


@dataclass(frozen=True, slots=True)
class NodeStatus:
    """How a node is doing."""

    stamp: int
    node: str
    seq: int
    state: Lifecycle
    rate_in: float = (
        NAN  # [Hz] states per second over the last period; commands, for a node that sends states
    )
    rate_out: float = NAN  # [Hz] commands per second; states, for a node that sends states
    latency_p50: float = NAN  # [us] state in -> command out
    latency_p99: float = NAN  # [us]
    latency_max: float = NAN  # [us]
    lateness_max: float = NAN  # [us] the loop behind its schedule, worst of the last period
    deadline_misses: int = 0
    dropped: int = 0  # telemetry dropped by the bounded queue
    rejected: Mapping[str, int] = field(default_factory=dict)  # what was refused, lost, not sent


@dataclass(frozen=True, slots=True)
class DeviceReport:
    """What a device itself says of its contact, to be put beside what is estimated here."""

    stamp: int
    finger: str
    seq: int
    slip_state: float = NAN  # its own code
    friction: float = NAN  # [-] its estimate
    grip_force: float = NAN  # [N] the normal force that it asks for


@dataclass(frozen=True, slots=True)
class GraspStatus:
    """How a grasp or release goes that was asked for; sent when its phase changes, and each second."""

    stamp: int
    node: str
    seq: int
    phase: GraspPhase
    reason: str = ""  # why it is not reached, or what it rests on; "" = nothing to say
    normal_force: float = NAN  # [N] the largest that a finger feels
    margin: float = NAN  # [-] least lower bound of the fingers that touch; NaN = not known


Message = (
    FingertipState
    | ContactEstimate
    | SlipMargin
    | ForceCommand
    | ModelHealth
    | LearnedParameter
    | NodeStatus
    | GraspStatus
    | DeviceReport
)
OF_NODES: Final = (NodeStatus, GraspStatus)
"""Messages of a whole node; the others are of a finger."""
