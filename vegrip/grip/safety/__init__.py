"""What input is believed, what happens without, and the limits that every command passes: settings.

:mod:`vegrip.grip.kernels` keeps to them in ``watchdog``, ``fail_safe`` and ``limits``. Whether a drive may
obey a command is answered here, by :func:`reason_to_reject`. Counter and checksum have been looked at by
the codec, and on a network the key of the sender. What is left is time: a command that was held back,
stamped by a wrong clock, or says that it lives for ever.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any, Final

from vegrip.clock import NS
from vegrip.config import constant, parameter
from vegrip.errors import ConfigError

MAX_FORCE_N: Final = 1e3
"""[N] Beyond any fingertip; a limit that is set higher by mistake would be none."""

MOST_RATE: Final = 1e5
"""[N/s] The same of rates."""


@dataclass(frozen=True)
class LimitSettings:
    """Bounds of the commanded grip force."""

    min_force: float = parameter(
        0.3, unit="N", low=0.0, high=MAX_FORCE_N, doc="least commanded force; keeps touch"
    )
    max_force: float = parameter(
        15.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="largest commanded force; state it, or a map does"
    )
    raise_rate: float = parameter(
        80.0, unit="N/s", low=0.0, high=MOST_RATE, doc="fastest rise of the command"
    )
    lower_rate: float = constant(8.0, unit="N/s", low=0.0, high=MOST_RATE, doc="fastest fall of the command")
    lifetime: float = parameter(0.1, unit="s", low=0.001, high=10.0, doc="a command expires after so long")

    def __post_init__(self) -> None:
        if not self.min_force <= self.max_force < math.inf:
            raise ConfigError(
                f"limits: 'min_force' is {self.min_force:g} N and 'max_force' {self.max_force:g} N;"
                " the least force must not exceed the largest, which must be finite"
            )


USUAL_LIMITS: Final = LimitSettings()
"""Where none are stated; then what fingers and object bear is not known, which is said."""


def limit_not_stated(limits: LimitSettings) -> str:
    """Return what to say where ``limits`` hold because nothing else was stated."""
    most = f"{limits.max_force:g} N"
    return f"limits.max_force is {most} because none is stated: state what fingers and object bear"


@dataclass(frozen=True)
class FailSafeSettings:
    """The grip of last resort."""

    force: float = parameter(
        5.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="fail-safe grip; lower commands ramp up to it"
    )
    hold_time: float = constant(
        0.25, unit="s", low=0.0, high=3600.0, doc="the last safe command is held so long"
    )
    ramp_rate: float = constant(
        10.0, unit="N/s", low=0.0, high=MOST_RATE, doc="rate of the ramp to the fail-safe grip"
    )


def _range(low: float, high: float, unit: str, kind: Callable[..., Any] = parameter) -> tuple[float, float]:
    declared: tuple[float, float] = kind((low, high), unit=unit, doc="least and largest believable value")
    return declared


@dataclass(frozen=True)
class Ranges:
    """Believable ranges, named as the channels of :class:`~vegrip.messages.FingertipState`."""

    normal_force: tuple[float, float] = _range(-5.0, 60.0, "N")
    tangential_force_x: tuple[float, float] = _range(-60.0, 60.0, "N")
    tangential_force_y: tuple[float, float] = _range(-60.0, 60.0, "N")
    torque_z: tuple[float, float] = _range(-2.0, 2.0, "N m")
    displacement: tuple[float, float] = _range(-0.05, 0.02, "m")
    temperature: tuple[float, float] = _range(-40.0, 150.0, "degrees Celsius", constant)
    slip: tuple[float, float] = _range(0.0, 1.0, "1", constant)
    slip_speed: tuple[float, float] = _range(-10.0, 10.0, "m/s", constant)
    contact_radius: tuple[float, float] = _range(0.0, 0.05, "m", constant)

    def __post_init__(self) -> None:
        for channel in fields(self):
            bounds = getattr(self, channel.name)
            if len(bounds) != 2 or not bounds[0] < bounds[1]:
                raise ConfigError(f"ranges: {channel.name!r} is {list(bounds)}; it must be [least, largest]")


NOT_MEASURED_S: Final = 3600.0
"""[s] ``force_frozen_after`` of a force that is computed: standing still is then no sign of a fault."""

MECHANICAL = ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement")


@dataclass(frozen=True)
class WatchdogSettings:
    """When input stops being believed."""

    time_out: float = parameter(0.05, unit="s", low=0.001, high=10.0, doc="input older than this is stale")
    frozen_after: float = parameter(
        0.25, unit="s", low=0.01, high=3600.0, doc="all values the same for so long: frozen"
    )
    force_frozen_after: float = parameter(
        2.0, unit="s", low=0.01, high=NOT_MEASURED_S,
        doc="the same of the normal force alone; 3600: it is not measured, and may stand still",
    )  # fmt: skip
    frozen_chance: float = constant(
        1e-7,
        unit="1",
        low=0.0,
        high=1.0,
        doc="frozen at once when a noisy normal force repeats itself more often than with this chance",
    )
    doubt_after: float = constant(
        0.05,
        unit="s",
        low=0.0,
        high=NOT_MEASURED_S,
        doc="normal force the same for so long: not lowered on its word",
    )
    stuck_travel: float = parameter(
        3e-4,
        unit="m",
        low=1e-6,
        high=1.0,
        doc="frozen when the normal force stands still while the tip is pressed in or unloaded by more",
    )
    recover_after: int = constant(5, unit="states", low=0, high=1_000_000, doc="good states that end a fault")
    ranges: Ranges = field(default_factory=Ranges)


AHEAD = 1 * NS  # [ns] by which a sender's clock may be ahead; a command further ahead would live longer
LONGEST_LIFE = 10 * NS  # [ns] the largest lifetime that can be configured


def reason_to_reject(normal_force: float, stamp: int, expires: int, now: int) -> str:
    """Return why a command of ``normal_force`` [N] must not be obeyed at ``now`` [ns], "" if it may."""
    if not math.isfinite(normal_force) or normal_force < 0.0:
        return "no usable force"
    if expires <= now:
        return "expired"
    if expires - stamp > LONGEST_LIFE:
        return "lives too long"
    return "from the future" if stamp - now > AHEAD else ""
