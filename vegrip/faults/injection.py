"""What goes wrong: each fault is a small class that begins and ends in a scene."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from random import Random
from typing import Any, Protocol

from vegrip.clock import NS
from vegrip.codec import Frame
from vegrip.faults.scene import Scene
from vegrip.messages import FingertipState
from vegrip.node.cosimulation import Participant
from vegrip.transport.node_faults import NO_FAULTS, NodeFaults
from vegrip.transport.simulated_can import SimulatedEndpoint

STATES = 0x200  # identifiers of FingertipStateFd of hand 0, one per finger
Sent = Iterable[tuple[int, Frame]]


class Injection(Protocol):
    """A fault."""

    def begin(self, scene: Scene) -> None:
        """Let it happen from now on."""

    def end(self, scene: Scene) -> None:
        """Let it be over."""


class _Tampering:
    """A fault of the frames with states on their way from the hand to the bus."""

    finger = -1  # only this one; -1: all

    def begin(self, scene: Scene) -> None:
        scene.hand.endpoint.tamper = self._tamper

    def end(self, scene: Scene) -> None:
        scene.hand.endpoint.tamper = None

    def _tamper(self, frame: Frame, now: int) -> Sent:
        concerned = frame.arbitration_id & ~0x7 == STATES and self.finger in (-1, frame.arbitration_id & 0x7)
        return self.falsified(frame, now) if concerned else ((now, frame),)

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Return what becomes of a frame with a state."""
        raise NotImplementedError


@dataclass
class Loss(_Tampering):
    """A share of the frames never reaches the bus."""

    share: float
    finger: int = -1
    random: Random = field(default_factory=lambda: Random(1), compare=False)  # noqa: S311 (no secret)

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Send it, or not."""
        return () if self.random.random() < self.share else ((now, frame),)


@dataclass
class Duplication(_Tampering):
    """Every frame is sent twice."""

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Send it again a millisecond later."""
        return (now, frame), (now + NS // 1000, frame)


@dataclass
class Reordering(_Tampering):
    """Every other frame is overtaken by the next one of its finger."""

    delay: float = 0.0075  # [s] one and a half periods

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Send even ones at once, odd ones later."""
        odd = frame.data[2] & 1  # the counter of the E2E header
        return ((now + odd * round(self.delay * NS), frame),)


@dataclass
class Delay(_Tampering):
    """Every frame comes late."""

    delay: float  # [s]

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Send it later."""
        return ((now + round(self.delay * NS), frame),)


@dataclass
class BitFlips(_Tampering):
    """One bit of every frame is wrong, behind the CRC of the bus."""

    random: Random = field(default_factory=lambda: Random(2), compare=False)  # noqa: S311 (no secret)

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Flip one bit anywhere."""
        bit = self.random.randrange(8 * len(frame.data))
        data = bytearray(frame.data)
        data[bit // 8] ^= 1 << bit % 8
        return ((now, frame._replace(data=bytes(data))),)


@dataclass
class Replay(_Tampering):
    """In place of the present frames old ones are sent, in order, with good checksums."""

    back: int = 40  # frames of each finger

    def begin(self, scene: Scene) -> None:
        """Remember frames for a while, then send them again."""
        self._kept: dict[int, list[Frame]] = {}
        super().begin(scene)

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Let the first ones pass and keep them; then send these, over and over."""
        kept = self._kept.setdefault(frame.arbitration_id, [])
        if len(kept) < self.back:
            kept.append(frame)
            return ((now, frame),)
        kept.append(kept.pop(0))
        return ((now, kept[-1]),)


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
class Babbling:
    """A node that is not ours sends one identifier without pause."""

    identifier: int

    def begin(self, scene: Scene) -> None:
        """Join the bus."""
        self._idiot = scene.endpoint()
        self._idiot.endure(NodeFaults(babble=self.identifier))

    def end(self, scene: Scene) -> None:  # noqa: ARG002
        """Be pulled out."""
        self._idiot.close()


@dataclass
class BadTransceiver:
    """All frames of a node go wrong on the bus: it turns bus-off, comes back, turns off again."""

    who: str  # "hand" or "grip"

    def begin(self, scene: Scene) -> None:
        """Disturb each frame."""
        self._endpoint(scene).endure(NodeFaults(corruption=1.0))

    def end(self, scene: Scene) -> None:
        """Disturb no more."""
        self._endpoint(scene).endure(NO_FAULTS)

    def _endpoint(self, scene: Scene) -> SimulatedEndpoint:
        participant: Participant = scene.hand if self.who == "hand" else scene.grip
        return participant.endpoint


@dataclass
class NoisyWire:
    """A share of all frames is disturbed, whoever sends them."""

    share: float

    def begin(self, scene: Scene) -> None:
        """Disturb."""
        for seed, participant in enumerate(scene.simulation.participants):
            participant.endpoint.endure(NodeFaults(corruption=self.share, seed=seed))

    def end(self, scene: Scene) -> None:
        """Disturb no more."""
        for participant in scene.simulation.participants:
            participant.endpoint.endure(NO_FAULTS)


@dataclass
class Killed:
    """The node that grips is killed, and started again at the end."""

    def begin(self, scene: Scene) -> None:
        """Kill it."""
        scene.simulation.kill(scene.grip)

    def end(self, scene: Scene) -> None:
        """Start another."""
        scene.start_grip()


@dataclass
class Starved:
    """The computer of the node that grips does something else."""

    duration: float  # [s]

    def begin(self, scene: Scene) -> None:
        """Take its time."""
        scene.simulation.starve(scene.grip, self.duration)

    def end(self, scene: Scene) -> None:
        """Nothing to undo."""


@dataclass
class SenderClockJump(_Lie):
    """The clock of the sensors jumps, where their stamps are used."""

    jump: float  # [s]

    def falsified(self, state: FingertipState) -> FingertipState:
        """Stamp with the clock that jumped."""
        return replace(state, stamp=state.stamp + round(self.jump * NS))


@dataclass
class SubscriberGone:
    """A node that listened is killed."""

    def begin(self, scene: Scene) -> None:
        """Join, and leave at once."""
        scene.endpoint().close()

    def end(self, scene: Scene) -> None:
        """Nothing to undo."""


@dataclass
class DiskFull:
    """The disk takes nothing."""

    def begin(self, scene: Scene) -> None:
        """Refuse."""
        self._set(scene, full=True)

    def end(self, scene: Scene) -> None:
        """Take again."""
        self._set(scene, full=False)

    def _set(self, scene: Scene, *, full: bool) -> None:
        if scene.recorder is not None:
            scene.recorder.writer.full = full
