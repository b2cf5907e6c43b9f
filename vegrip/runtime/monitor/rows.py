"""What is known of one node: its newest status, whether it is there, what is late or refused. Pure."""

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from vegrip.clock import NS
from vegrip.messages import (
    KNOWN,
    PROBED,
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    Lifecycle,
    Message,
    ModelHealth,
    NodeStatus,
    SlipMargin,
)

FRESH = 0.5  # [s] a number older than this says nothing of now and is not shown
M = TypeVar("M", bound=Message)


@dataclass(frozen=True, slots=True)
class _Received:
    """A message, when it came, and how long after the one before."""

    message: Message
    at: int  # [ns]
    gap: float  # [s]


@dataclass(frozen=True, slots=True)
class Now:
    """What is said of a finger now; None where it is too old."""

    state: FingertipState | None
    contact: ContactEstimate | None
    margin: SlipMargin | None
    command: ForceCommand | None
    health: ModelHealth | None
    margin_age: float  # [s] of the newest margin, shown or not

    @property
    def friction(self) -> str:
        """What is done with friction on purpose, by :attr:`vegrip.messages.ModelHealth.friction`."""
        return self.health.friction if self.health is not None else ""

    @property
    def lets_go(self) -> bool:
        """Whether a small margin is meant.

        While friction is probed, slip is what is waited for, and felt. A finger whose friction is known holds
        with less than the confidence of the reported bound, so that its margin itself has to be gone.
        """
        if self.margin is None:
            return False
        return self.friction == PROBED or (self.friction == KNOWN and not self.margin.margin.value < 0.0)


@dataclass
class FingerRow:
    """The newest message of every kind, each with its own age."""

    source: str = ""  # full name of the node that the newest message came from, "" = not known
    announced: Condition | None = None  # what the log knows of its input; None = there was none yet
    pending: tuple[Condition, int] | None = None  # what the log does not know yet, and since when [ns]
    _last: dict[type[object], _Received] = field(default_factory=dict)

    def put(self, message: Message, now: int) -> None:
        """Keep ``message``, which came at ``now`` [ns]."""
        before = self._last.get(type(message))
        gap = 0.0 if before is None else (now - before.at) / NS
        self._last[type(message)] = _Received(message, now, gap)

    def newest(self, kind: type[M]) -> M | None:
        last = self._last.get(kind)
        return last.message if last is not None and isinstance(last.message, kind) else None

    def fresh(self, kind: type[M], now: int) -> M | None:
        return self.newest(kind) if self.age(kind, now) <= self._patience(kind) else None

    def now(self, now: int) -> Now:
        """Return what is said of the finger at ``now`` [ns]."""
        kinds = (FingertipState, ContactEstimate, SlipMargin, ForceCommand, ModelHealth)
        state, contact, margin, command, health = (self.fresh(kind, now) for kind in kinds)
        return Now(state, contact, margin, command, health, self.age(SlipMargin, now))  # type: ignore[arg-type]

    def age(self, kind: type[object], now: int) -> float:
        """Return how old the newest of ``kind`` is [s]; inf = there is none.

        A message that repeats an old estimate is as old as what the estimate rests on.
        """
        last = self._last.get(kind)
        if last is None:
            return math.inf
        return (now - last.at) / NS + _age_inside(last.message)

    def _patience(self, kind: type[object]) -> float:
        """Return how old a message may be; health comes seldom, so its own pace counts."""
        return FRESH + (self._last[kind].gap if kind is ModelHealth and kind in self._last else 0.0)


def _age_inside(message: Message) -> float:
    """Return how old the youngest estimate in ``message`` was when it was sent [s]; 0 = not stated."""
    estimates: tuple[Estimate, ...] = ()
    if isinstance(message, SlipMargin):
        estimates = (message.margin,)
    if isinstance(message, ContactEstimate):
        estimates = (message.normal_force, message.indentation, message.contact_radius)
    return min((one.age for one in estimates if math.isfinite(one.age)), default=0.0)


STATUS_PERIOD = 1.0  # [s] of NodeStatus, where nothing else is known
MISSED = 2.0  # statuses that may fail to come on a busy machine
RECENT_REFUSAL_S = 10.0  # [s] a refusal so long ago is still shown as news


@dataclass(frozen=True)
class Present:
    """A node that runs on this machine, or has failed there, as the registry knows it."""

    name: str  # in full, with namespace
    pid: int = 0
    status_period: float = STATUS_PERIOD  # [s]
    fingers: tuple[str, ...] = ()  # in the order of its hand, as the board calls them
    failure: str = ""  # why it runs no more


class Presence(Enum):
    """Whether a node is there."""

    STARTING = "starting"  # its process runs, it has not said anything
    RUNNING = "running"
    SILENT = "silent"  # it says nothing, though its process may run
    GONE = "gone"  # its process has died
    STOPPED = "stopped"  # it has ended in order


@dataclass
class NodeRow:
    """One node."""

    since: int  # [ns] when its process was first seen
    is_old: bool = False  # it ran before the monitor started
    status: NodeStatus | None = None
    presence: Presence = Presence.STARTING
    failure: str = ""  # why it runs no more
    present: Present | None = None  # None: it is not in the registry (any more)
    has_left: bool = False  # the registry
    late: float = 0.0  # [1/s] deadlines missed, over the last status period
    sends: bool = False  # states or commands, not only statuses
    recent: dict[str, int] = field(default_factory=dict)  # refusal: [ns] when it was last counted
    is_compared: bool = False  # whether two statuses show what was refused lately
    _spoke: int = 0  # [ns] the newest message of any kind
    _streamed: int = 0  # [ns] the newest that is no status
    _pid: int = 0
    _status_at: int = 0  # [ns]
    _period: float = STATUS_PERIOD  # [s] between its last two statuses

    def receive(self, message: object, now: int) -> None:
        """Note that the node has said something."""
        self._spoke = now
        if isinstance(message, NodeStatus):
            self._update(message, now)
        else:
            self._streamed = now

    def attend(self, present: Present | None, now: int) -> None:
        self.failure = present.failure if present is not None else ""
        if present is not None and not self.failure:
            if present.pid != self._pid:
                self.since, self._pid, self._period = now, present.pid, present.status_period
            self.present, self.has_left = present, False
        elif self.present is not None:
            self.present, self.has_left = None, True

    def age(self, now: int) -> float:
        """Return the time since it last said something, or since it was first known [s]."""
        return (now - max(self._spoke, self.since)) / NS

    def is_overdue(self, now: int) -> bool:
        """Whether it has missed the time of its last status by half a second, though it may only be late."""
        return self.age(now) > FRESH + self._period

    @property
    def last_received(self) -> int:
        """When it last said something [ns]."""
        return max(self._spoke, self.since)

    @property
    def late_share(self) -> float:
        """Share of the commands that left after their deadline, over the last status period.

        Zero for a node that answers no states: what it has late are its ticks.
        """
        if self.status is None or not math.isfinite(self.status.latency_p50) or self.status.rate_out <= 0.0:
            return 0.0
        return min(self.late / self.status.rate_out, 1.0)

    def judge(self, now: int, awake_since: int) -> Presence:
        """Return whether it is there at ``now``; silence before ``awake_since`` [ns] does not count."""
        if self.failure:
            return Presence.GONE
        is_finalized = self.status is not None and self.status.state is Lifecycle.FINALIZED
        if self.has_left or (is_finalized and self._is_last_word()):
            return Presence.STOPPED
        if now - max(self.last_received, awake_since) > self._patience() * NS:
            started = self._spoke >= self.since
            return Presence.SILENT if started or self.present is None else Presence.STARTING
        return Presence.RUNNING if self._spoke >= self.since else self.presence

    def _is_last_word(self) -> bool:
        """Return whether no new process of this name has begun since the last status."""
        return self.present is None or self._status_at >= self.since

    def _patience(self) -> float:
        """Return how long it may be silent [s]: one that streams has no reason to pause."""
        streams = self._streamed > 0 and self._spoke - self._streamed < FRESH * NS
        return FRESH if streams else FRESH + MISSED * self._period

    def _update(self, status: NodeStatus, now: int) -> None:
        before, self.status = self.status, status
        gap = (now - self._status_at) / NS
        self._status_at = now
        self.sends = self.sends or status.rate_out > 0.0
        if before is None or status.seq <= before.seq:
            self.is_compared = False
            return  # the first of this process
        self.is_compared = True
        if self.present is None and gap < 2.0 * self._period + FRESH:
            self._period = gap
        self.late = max(status.deadline_misses - before.deadline_misses, 0) / max(gap, 1e-3)
        if before.rate_in > 0.0 and status.rate_in > 0.0:  # alone on a bus nothing is acknowledged
            for name, count in status.rejected.items():
                if count > before.rejected.get(name, 0):
                    self.recent[name] = now

    def refusals(self, now: int) -> dict[str, int]:
        """Return what has been refused in the last seconds, with the counts since the start."""
        counts = self.status.rejected if self.status is not None else {}
        return {
            name: counts[name]
            for name, at in self.recent.items()
            if name in counts and now - at < RECENT_REFUSAL_S * NS
        }
