"""Faults of the sensors: counter and checksum are in order, what is said is not."""

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

from validation.faults.testbed import Scene
from vegrip.clock import NS
from vegrip.messages import FingertipState


class _Lie:
    """A fault of the sensors: counter, stamp and checksum are in order, values are not."""

    def begin(self, scene: Scene) -> None:
        scene.hand_node.falsify = self.falsified

    def end(self, scene: Scene) -> None:
        scene.hand_node.falsify = None

    def falsified(self, state: FingertipState) -> FingertipState:
        """Return what the sensor says."""
        raise NotImplementedError


@dataclass
class Frozen(_Lie):
    """All values stand still."""

    kept: dict[str, FingertipState] = field(default_factory=dict)

    def falsified(self, state: FingertipState) -> FingertipState:
        """Say what was said first."""
        first = self.kept.setdefault(state.finger, state)
        return replace(first, stamp=state.stamp, seq=state.seq)


@dataclass
class Saturated(_Lie):
    """The normal force stands at a limit of the sensor."""

    value: float  # [N]

    def falsified(self, state: FingertipState) -> FingertipState:
        """Say the limit."""
        return replace(state, normal_force=self.value)


@dataclass
class NotANumber(_Lie):
    """Some quantities, or all, are NaN."""

    channels: tuple[str, ...] = ()

    def falsified(self, state: FingertipState) -> FingertipState:
        """Take values out."""
        names = self.channels or [f.name for f in fields(state) if f.name not in ("stamp", "finger", "seq")]
        missing: dict[str, Any] = dict.fromkeys(names, math.nan)
        return replace(state, **missing)


@dataclass
class SenderClockJump(_Lie):
    """The clock of the sensors jumps, where their stamps are used."""

    jump: float  # [s]

    def falsified(self, state: FingertipState) -> FingertipState:
        """Stamp with the clock that jumped."""
        return replace(state, stamp=state.stamp + round(self.jump * NS))
