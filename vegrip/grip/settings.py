"""Parameters of the grasp force node."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from vegrip.config import build, check, constant, constants, declaration, fixed_parameter, parameter
from vegrip.errors import ConfigError, suggestion
from vegrip.grip.allocation.internal_forces import InternalForces, contacts_of
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.grasp_memory import BELIEF_MOST
from vegrip.grip.policies import find_policy
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.policies.policy import GripPolicy
from vegrip.grip.safety import USUAL_LIMITS, FailSafeSettings, LimitSettings, WatchdogSettings

USUAL_THUMB = "thumb"
"""Where no other is named; a hand need not have it."""


@dataclass(frozen=True)
class ControlSettings:
    """How the grasp is controlled; the same for all its fingers."""

    policy: str = fixed_parameter(
        "margin",
        doc="rule that finds the required force: margin, constant, cone, elastic, or one of another package",
    )
    policy_settings: dict[str, Any] = fixed_parameter({}, doc="of a policy other than margin")
    thumb: str = fixed_parameter(USUAL_THUMB, doc="finger that the others press against; empty = no balance")
    contacts: dict[str, Any] = fixed_parameter(
        {}, doc="place [m] and inward normal of each contact, instead of a thumb"
    )
    report_period: float = parameter(0.02, unit="s", low=0.0, high=10.0, doc="of estimates; 0 = every state")
    health_period: float = constant(0.2, unit="s", low=0.0, high=3600.0, doc="of ModelHealth")
    learned_period: float = constant(1.0, unit="s", low=0.0, high=3600.0, doc="of LearnedParameter")
    grip: GripSettings = parameter(GripSettings(), doc="the margin grip")
    friction: FrictionSettings = fixed_parameter(FrictionSettings(), doc="what the fingers learn of friction")
    limits: LimitSettings = parameter(USUAL_LIMITS, doc="passed by every command")
    fail_safe: FailSafeSettings = parameter(FailSafeSettings(), doc="under faults")
    watchdog: WatchdogSettings = parameter(WatchdogSettings(), doc="supervision of the input")

    def __post_init__(self) -> None:
        policy_settings(self)  # says what cannot be used

    @property
    def is_built_in(self) -> bool:
        return find_policy(self.policy).make is None


def check_settings(settings: ControlSettings, fingers: Sequence[str], known: object = None) -> None:
    """Refuse ``settings`` that the ``fingers`` cannot use; see :func:`vegrip.config.check` for ``known``.

    Raises:
        ConfigError: a value is not as it is declared, the thumb is none of the fingers, or these are too
            many to learn friction.

    """
    check(settings, "settings", known)
    if settings.thumb not in {*fingers, "", USUAL_THUMB}:
        raise ConfigError(f"settings: 'thumb' is {settings.thumb!r}; {suggestion(settings.thumb, fingers)}")
    if settings.friction.learning and len(fingers) > BELIEF_MOST:
        raise ConfigError(
            f"settings.friction: 'learning' is for at most {BELIEF_MOST} fingers, not {len(fingers)}"
        )


FIXED = tuple(
    field.name
    for field in fields(ControlSettings)
    if field.name not in constants(ControlSettings) and not declaration(ControlSettings, field.name).live
)
"""Names of what stays as it is while a hand grips."""


def fixed_changes(before: ControlSettings, after: ControlSettings) -> Iterator[str]:
    """Yield the dotted names of what is fixed and differs."""
    for name in FIXED:
        yield from _differences(name, getattr(before, name), getattr(after, name))


def _differences(name: str, before: Any, after: Any) -> Iterator[str]:
    if is_dataclass(before):
        for field in fields(before):
            inner = field.name
            yield from _differences(f"{name}.{inner}", getattr(before, inner), getattr(after, inner))
    elif before != after:
        yield name


def make_policy(settings: ControlSettings) -> GripPolicy:
    """Return a new policy of the kind the settings name, one of another package."""
    make = find_policy(settings.policy).make
    if make is None:
        raise ConfigError(
            f"the policy {settings.policy!r} is one of the finger step; there is no object of it"
        )
    return make(policy_settings(settings))


def policy_settings(settings: ControlSettings) -> Any:
    """Return the settings of the policy that is named."""
    kind = find_policy(settings.policy)
    if kind.settings is not GripSettings:
        return build(kind.settings, settings.policy_settings, f"policy_settings of {settings.policy!r}")
    if settings.policy_settings:
        raise ConfigError(
            f"'policy_settings' are for other policies; {settings.policy!r} has the table 'grip'"
        )
    return settings.grip


Share = Callable[[Mapping[str, float]], Mapping[str, float]]
"""From what each finger needs [N] to what each is to press with [N]."""


def make_share(settings: ControlSettings, fingers: Sequence[str]) -> Share | None:
    """Return how the ``fingers`` share internal forces by their contacts; None: against the thumb."""
    if not settings.contacts:
        return None
    unknown = settings.contacts.keys() - set(fingers)
    if unknown:
        raise ConfigError(
            f"'contacts' has {', '.join(sorted(unknown))}; the fingers are {', '.join(fingers)}"
        )
    return InternalForces(contacts_of(settings.contacts, "grasp")).shared
