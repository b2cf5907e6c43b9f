"""Parameters of the grasp force node."""

from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.control.baselines import ConeSettings, ConstantGrip, ConstantSettings, FrictionCone
from vegrip.control.fail_safe import FailSafeSettings
from vegrip.control.grip import GripSettings, MarginGrip
from vegrip.control.limits import LimitSettings
from vegrip.control.policy import GripPolicy
from vegrip.control.watchdog import WatchdogSettings


@dataclass(frozen=True)
class ControlSettings:
    """How the grasp is controlled; the same for all its fingers."""

    policy: str = parameter(
        "margin", choices=("margin", "constant", "cone"), doc="which rule finds the wanted force", live=False
    )
    thumb: str = parameter(
        "thumb", doc="finger that the others press against; empty = no balance", live=False
    )
    report_period: float = parameter(0.02, unit="s", low=0.0, high=10.0, doc="of estimates; 0 = every state")
    health_period: float = parameter(0.2, unit="s", low=0.0, high=60.0, doc="of ModelHealth")
    grip: GripSettings = parameter(GripSettings(), doc="the margin grip")
    constant: ConstantSettings = parameter(ConstantSettings(), doc="the constant grip")
    cone: ConeSettings = parameter(ConeSettings(), doc="the Coulomb cone")
    limits: LimitSettings = parameter(LimitSettings(), doc="passed by every command")
    fail_safe: FailSafeSettings = parameter(FailSafeSettings(), doc="under faults")
    watchdog: WatchdogSettings = parameter(WatchdogSettings(), doc="supervision of the input")


def make_policy(settings: ControlSettings) -> GripPolicy:
    """Return a new policy of the kind the settings name."""
    if settings.policy == "constant":
        return ConstantGrip(settings.constant)
    if settings.policy == "cone":
        return FrictionCone(settings.cone)
    return MarginGrip(settings.grip)


def apply_policy(policy: GripPolicy, settings: ControlSettings) -> None:
    """Give ``policy`` its new settings; it keeps its memory."""
    match policy:
        case ConstantGrip():
            policy.settings = settings.constant
        case FrictionCone():
            policy.settings = settings.cone
        case MarginGrip():
            policy.settings = settings.grip
