"""What is known of one finger: the newest message of each kind, and how old it is. Pure."""

import math
from dataclasses import dataclass, field
from typing import TypeVar

from vegrip.clock import NS
from vegrip.messages import (
    Condition,
    ContactEstimate,
    Estimate,
    Message,
    ModelHealth,
    SlipMargin,
)

FRESH = 0.5  # [s] a number older than this says nothing of now and is not shown
M = TypeVar("M", bound=Message)


@dataclass(frozen=True, slots=True)
class _Heard:
    """A message, when it came, and how long after the one before."""

    message: Message
    at: int  # [ns]
    gap: float  # [s]


@dataclass
class FingerRow:
    """The newest message of every kind, each with its own age."""

    source: str = ""  # full name of the node that the newest message came from, "" = not known
    announced: Condition | None = None  # what the log knows of its input; None = there was none yet
    pending: tuple[Condition, int] | None = None  # what the log does not know yet, and since when [ns]
    _heard: dict[type[object], _Heard] = field(default_factory=dict)

    def put(self, message: Message, now: int) -> None:
        """Keep ``message``, which came at ``now`` [ns]."""
        before = self._heard.get(type(message))
        gap = 0.0 if before is None else (now - before.at) / NS
        self._heard[type(message)] = _Heard(message, now, gap)

    def newest(self, kind: type[M]) -> M | None:
        heard = self._heard.get(kind)
        return heard.message if heard is not None and isinstance(heard.message, kind) else None

    def fresh(self, kind: type[M], now: int) -> M | None:
        return self.newest(kind) if self.age(kind, now) <= self._patience(kind) else None

    def age(self, kind: type[object], now: int) -> float:
        """Return how old the newest of ``kind`` is [s]; inf = there is none.

        A message that repeats an old estimate is as old as what the estimate rests on.
        """
        heard = self._heard.get(kind)
        if heard is None:
            return math.inf
        return (now - heard.at) / NS + _age_inside(heard.message)

    def _patience(self, kind: type[object]) -> float:
        """Return how old a message may be; health comes seldom, so its own pace counts."""
        return FRESH + (self._heard[kind].gap if kind is ModelHealth and kind in self._heard else 0.0)


def _age_inside(message: Message) -> float:
    """Return how old the youngest estimate in ``message`` was when it was sent [s]; 0 = not stated."""
    estimates: tuple[Estimate, ...] = ()
    if isinstance(message, SlipMargin):
        estimates = (message.margin,)
    if isinstance(message, ContactEstimate):
        estimates = (message.normal_force, message.indentation, message.contact_radius)
    return min((one.age for one in estimates if math.isfinite(one.age)), default=0.0)
