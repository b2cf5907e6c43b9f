"""Parameters of the grasp force node."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.grip.allocation.balance import balance_forces
from vegrip.grip.allocation.internal_forces import InternalForces, contacts_of
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.policies.baselines import (
    ConeSettings,
    ConstantGrip,
    ConstantSettings,
    ElasticSettings,
    ElasticSurface,
    FrictionCone,
)
from vegrip.grip.policies.margin_grip import GripSettings, MarginGrip
from vegrip.grip.policies.policy import GripPolicy
from vegrip.grip.safety.fail_safe import FailSafeSettings
from vegrip.grip.safety.limits import LimitSettings
from vegrip.grip.safety.watchdog import WatchdogSettings


@dataclass(frozen=True)
class ControlSettings:
    """How the grasp is controlled; the same for all its fingers."""

    policy: str = parameter(
        "margin",
        choices=("margin", "constant", "cone", "elastic"),
        doc="which rule finds the wanted force",
        live=False,
    )
    thumb: str = parameter(
        "thumb", doc="finger that the others press against; empty = no balance", live=False
    )
    contacts: dict[str, Any] = parameter(
        {}, doc="place [m] and inward normal of each contact, instead of a thumb", live=False
    )
    report_period: float = parameter(0.02, unit="s", low=0.0, high=10.0, doc="of estimates; 0 = every state")
    health_period: float = parameter(0.2, unit="s", low=0.0, high=60.0, doc="of ModelHealth")
    learned_period: float = parameter(1.0, unit="s", low=0.0, high=60.0, doc="of LearnedParameter")
    grip: GripSettings = parameter(GripSettings(), doc="the margin grip")
    friction: FrictionSettings = parameter(FrictionSettings(), doc="what the fingers learn of friction")
    constant: ConstantSettings = parameter(ConstantSettings(), doc="the constant grip")
    cone: ConeSettings = parameter(ConeSettings(), doc="the Coulomb cone")
    elastic: ElasticSettings = parameter(ElasticSettings(), doc="the elastic limit surface")
    limits: LimitSettings = parameter(LimitSettings(), doc="passed by every command")
    fail_safe: FailSafeSettings = parameter(FailSafeSettings(), doc="under faults")
    watchdog: WatchdogSettings = parameter(WatchdogSettings(), doc="supervision of the input")


def make_policy(settings: ControlSettings) -> GripPolicy:
    """Return a new policy of the kind the settings name."""
    if settings.policy == "constant":
        return ConstantGrip(settings.constant)
    if settings.policy == "cone":
        return FrictionCone(settings.cone)
    if settings.policy == "elastic":
        return ElasticSurface(settings.elastic)
    return MarginGrip(settings.grip)


Share = Callable[[Mapping[str, float]], Mapping[str, float]]
"""From what each finger needs [N] to what each is to press with [N]."""


def make_share(settings: ControlSettings, fingers: Sequence[str]) -> Share:
    """Return how the ``fingers`` share internal forces: by their contacts, else against the thumb.

    Raises:
        ConfigError: ``contacts`` names a finger that the hand does not have, or they cannot balance.

    """
    if not settings.contacts:
        return lambda needs: balance_forces(needs, settings.thumb)
    unknown = settings.contacts.keys() - set(fingers)
    if unknown:
        raise ConfigError(
            f"'contacts' has {', '.join(sorted(unknown))}; the fingers are {', '.join(fingers)}"
        )
    return InternalForces(contacts_of(settings.contacts, "grasp")).shared


def apply_policy(policy: GripPolicy, settings: ControlSettings) -> None:
    """Give ``policy`` its new settings; it keeps its memory."""
    match policy:
        case ConstantGrip():
            policy.settings = settings.constant
        case FrictionCone():
            policy.settings = settings.cone
        case ElasticSurface():
            policy.settings = settings.elastic
        case MarginGrip():
            policy.settings = settings.grip
