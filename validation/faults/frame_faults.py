"""Faults of the frames with states, on their way from the hand to the bus."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from random import Random

from validation.faults.testbed import Scene
from vegrip.clock import NS
from vegrip.transport.codec import Frame

STATES = frozenset({0x200, 0x100, 0x140, 0x180})
"""Identifiers of FingertipStateFd and of the classic FingertipState1 to 3 of hand 0, finger 0."""
Sent = Iterable[tuple[int, Frame]]


class _Tampering:
    """A fault of the frames with states on their way from the hand to the bus."""

    finger = -1  # only this one; -1: all

    def begin(self, scene: Scene) -> None:
        scene.hand.endpoint.tamper = self._tamper

    def end(self, scene: Scene) -> None:
        scene.hand.endpoint.tamper = None

    def _tamper(self, frame: Frame, now: int) -> Sent:
        concerned = frame.arbitration_id & ~0x7 in STATES and self.finger in (-1, frame.arbitration_id & 0x7)
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
        odd = frame.data[2 if frame.fd else 1] & 1  # the counter of the E2E header
        return ((now + odd * round(self.delay * NS), frame),)


@dataclass
class Truncation(_Tampering):
    """Of every frame only the first bytes are sent."""

    length: int = 8

    def falsified(self, frame: Frame, now: int) -> Sent:
        """Send its beginning."""
        length = min(self.length, len(frame.data) // 2)
        return ((now, frame._replace(data=frame.data[:length])),)


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
