"""An estimator that knows Coulomb's cone and nothing else: what is tested here is the node."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import pytest

from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.messages import (
    Channel,
    ContactEstimate,
    Estimate,
    FingertipState,
    ModelHealth,
    SlipMargin,
)
from vegrip.runtime import background

MU = 0.8
TOUCH = 0.05  # [N]
PERIOD = 2_000_000  # [ns]


@dataclass
class ConeEstimator:
    """Exact arithmetic on the last state, so that a test can say what the command must be."""

    finger: str
    resets: int = 0
    confidence: float = math.nan  # asked last
    seen: list[FingertipState] = field(default_factory=list)

    def assimilate(self, state: FingertipState) -> None:
        self.seen.append(state)

    @property
    def in_contact(self) -> bool:
        return self.contact_estimate().in_contact

    @property
    def normal_force(self) -> Estimate:
        return self.contact_estimate().normal_force

    def contact_estimate(self) -> ContactEstimate:
        state = self.seen[-1]
        known = not math.isnan(state.normal_force)
        return ContactEstimate(
            stamp=state.stamp,
            finger=state.finger,
            seq=state.seq,
            in_contact=known and state.normal_force > TOUCH,
            channels=Channel.FORCE | Channel.TANGENTIAL,
            normal_force=Estimate(state.normal_force, 0.01, known, 0.0),
        )

    def slip_margin(self) -> SlipMargin:
        last = self.seen[-1]
        margin = 1.0 - self._load / (MU * last.normal_force) if last.normal_force > TOUCH else math.nan
        estimate = Estimate(margin, 0.01, math.isfinite(margin), 0.0)
        return SlipMargin(last.stamp, last.finger, last.seq, estimate, margin, 0.95)

    def health(self) -> ModelHealth:
        return ModelHealth(stamp=0, finger=self.finger, seq=len(self.seen), nis=1.0, consistent=True)

    def reset_health(self) -> None:
        pass

    def least_force(self, margin: float, confidence: float, load: tuple[float, float] | None = None) -> float:
        self.confidence = confidence
        return (self._load if load is None else load[0]) / (MU * (1.0 - margin))

    def reset(self) -> None:
        self.resets += 1

    @property
    def _load(self) -> float:
        return math.hypot(self.seen[-1].tangential_force_x, self.seen[-1].tangential_force_y)


@pytest.fixture(autouse=True)
def helpers_that_take_their_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let helpers of a node run as the tests do: behind all workers of a run they would hardly begin."""
    monkeypatch.setattr(background, "_in_front", lambda _idle: [])


MakeNode = Callable[..., GraspForce]


@pytest.fixture
def make_node() -> MakeNode:
    """Give a function that makes an active node with cone estimators."""

    def make(fingers: Sequence[str] = ("index",), settings: ControlSettings | None = None) -> GraspForce:
        node = GraspForce("grasp", fingers, ConeEstimator, settings or ControlSettings())
        node.configure()
        node.activate()
        return node

    return make


@pytest.fixture
def state() -> Callable[..., FingertipState]:
    """Give a function that makes the ``count``-th state (500 Hz) of a living finger, with changes."""

    def make(count: int, finger: str = "index", **changes: float) -> FingertipState:
        wobble = 1e-3 * math.sin(count)
        values: dict[str, float] = {
            "normal_force": 3.0 + wobble,
            "tangential_force_x": 1.2,
            "tangential_force_y": 0.0,
            "torque_z": 1e-4 * wobble,
            "displacement": 1e-3,
            "slip": 0.0,
        }
        return FingertipState(**{"stamp": count * PERIOD, "finger": finger, "seq": count} | values | changes)

    return make
