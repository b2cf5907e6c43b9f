"""The settings of the cases, as tables of a launch file; a policy and an estimator of a user."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from vegrip.nodes.grasp_force import node_of

from vegrip.config import build, parameter
from vegrip.estimator import ContactEstimator
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters
from vegrip.grip.policies import POLICIES
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.policy import PolicyKind
from vegrip.messages import FingertipState, Reason
from vegrip.runtime import NodeContext

TIPS = {"tip": {"radius": 9e-3}, "tips": {"thumb": {"radius": 13e-3}}}
LEARNING = {
    "grip": {"wanted_margin": 0.1, "drive_lag": 0.01},
    "friction": {"learning": True, "slip_threshold": 1e-4, "slip_delay": 0.02},
}  # fmt: skip
PLACES = {
    "thumb": (0.0, 0.0, -0.01), "index": (-0.033, 0.0, 0.01), "middle": (-0.011, 0.0, 0.01),
    "ring": (0.011, 0.0, 0.01), "little": (0.033, 0.0, 0.01),
}  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """How the node is set, and how its end of the wire is."""

    table: Mapping[str, Any] = field(default_factory=dict)
    constants: Mapping[str, Any] = field(default_factory=dict)  # with other values, as a table
    order_window: float = 0.0  # [s]
    sender_time: bool | None = None  # None: as the wire has it by itself
    estimate_clock: bool = False
    has_contacts: bool = False
    own_estimator: bool = False
    tape: str = "hand"  # recording that fits it

    def parameters(self, fingers: Sequence[str]) -> dict[str, Any]:
        """Return the table ``[parameters]`` for a hand with ``fingers``."""
        found: dict[str, Any] = {"suspects": False, "tip": TIPS["tip"]}
        tips: Any = TIPS["tips"]
        found["tips"] = {name: tip for name, tip in tips.items() if name in fingers}
        found["estimator"] = {"hold": "force", **self.table.get("estimator", {})}
        found |= {key: value for key, value in self.table.items() if key != "estimator"}
        if self.has_contacts:
            width = float(len(fingers) > 2)  # two fingers press straight against each other
            found["contacts"] = {
                name: {
                    "place": [width * PLACES[name][0], *PLACES[name][1:]],
                    "normal": [0.0, 0.0, 1.0 if name == "thumb" else -1.0],
                }
                for name in fingers
            }
        return found


SETTINGS: dict[str, Setting] = {
    "default": Setting(),
    "learning": Setting(LEARNING, tape="learning"),
    "elastic": Setting({"policy": "elastic", "policy_settings": {"friction": 0.35}}),
    "cone": Setting({"policy": "cone", "policy_settings": {"safety": 1.5}}),
    "constant": Setting({"policy": "constant", "policy_settings": {"force": 4.0}}),
    "own policy": Setting({"policy": "golden", "policy_settings": {"share": 1.7}}),
    "failing policy": Setting({"policy": "golden", "policy_settings": {"share": 1.7, "fails_at": 700}}),
    "own estimator": Setting(own_estimator=True),
    "contacts": Setting(has_contacts=True),
    "ellipse": Setting({"estimator": {"hold": "mixed"}}, {"estimator": {"surface": "ellipse", "late": 40}}),
    "order window": Setting(order_window=0.012),
    "sender's clock": Setting(sender_time=True),
    "estimated clock": Setting(estimate_clock=True),
}


@dataclass(frozen=True)
class OwnSettings:
    """Of the policy below."""

    share: float = parameter(1.5, unit="1", low=1.0, high=10.0, doc="of the least force")
    fails_at: int = parameter(0, low=0, high=10**6, doc="call at which it raises; 0 = never")


class OwnPolicy:
    """A share more than the least force, slowly; the load where that is not known."""

    uses_least_force = True

    def __init__(self, settings: OwnSettings) -> None:
        self.settings = settings
        self._calls = 0
        self._last = 0.0

    def reset(self) -> None:
        """Forget the last force."""
        self._last = 0.0

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:
        """Return the wanted force [N]."""
        self._calls += 1
        if self._calls == self.settings.fails_at:
            raise ZeroDivisionError("as its setting asks")
        if not demand.trusted or math.isnan(demand.least_force):
            load = demand.tangential_force
            return (held, Reason.UNTRUSTED) if math.isnan(load) else (max(held, 2.0 * load), Reason.RAISE)
        wanted = self.settings.share * demand.least_force + (2.0 if demand.slipping else 0.0)
        self._last += (wanted - self._last) * min(1.0, dt / 0.1)
        force = max(wanted, self._last)
        return force, Reason.RAISE if force > held else Reason.LOWER


POLICY = PolicyKind(OwnPolicy, OwnSettings)


class OwnEstimator:
    """An estimator that a user has put around ours: it forgets every other temperature."""

    def __init__(self, inner: ContactEstimator) -> None:
        self._inner = inner
        self._count = 0

    def assimilate(self, state: FingertipState) -> None:
        """Take in one state."""
        self._count += 1
        self._inner.assimilate(state)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


def changed(settings: Any, table: Mapping[str, Any]) -> Any:
    """Return ``settings`` with the values of ``table``, tables within tables."""
    known = {name: value for name, value in table.items() if hasattr(settings, name)}
    return replace(
        settings,
        **{n: changed(getattr(settings, n), v) if isinstance(v, dict) else v for n, v in known.items()},
    )


def make_node(setting: Setting, fingers: tuple[str, ...]) -> GraspForce:
    """Return the node that grips, not configured yet."""
    POLICIES["golden"] = "validation.golden.settings:POLICY"
    parameters = build(GraspParameters, setting.parameters(fingers), "golden")
    node = node_of(changed(parameters, setting.constants), NodeContext("grip", fingers=fingers))
    if setting.own_estimator:
        make: Any = node._make_estimator
        node._make_estimator = lambda name: OwnEstimator(make(name))
    return node
