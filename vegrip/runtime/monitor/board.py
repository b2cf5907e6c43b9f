"""The board: what is known of fingers and nodes, how old it is, and a short log. Pure; time is passed in."""

from collections import deque
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field

from vegrip import messages
from vegrip.clock import NS
from vegrip.jsonable import jsonable
from vegrip.runtime.monitor.rows import FRESH, FingerRow, NodeRow, Presence, Present

LOG_LINES = 8
MOST_FINGERS = 64  # a sender of made-up names must not make the board grow
MOST_NODES = 64
BUSY, TOO_BUSY = 0.01, 0.1  # shares of late commands from which on a machine is called so
CONSEQUENCE = 5.0  # [s] input that ceases so soon around the end of a node has ceased because of it
CONDITION_STYLE = {messages.Condition.OK: "green", messages.Condition.DEGRADED: "yellow"}  # all others red
ABSENT = (messages.Condition.STALE, messages.Condition.MISSING)
MESSAGE_OF_TOPIC: dict[str, type[messages.Message]] = {
    "state": messages.FingertipState,
    "contact": messages.ContactEstimate,
    "margin": messages.SlipMargin,
    "command": messages.ForceCommand,
    "health": messages.ModelHealth,
    "device": messages.DeviceReport,
}


@dataclass(frozen=True, slots=True)
class LogLine:
    """Something that happened."""

    time: float  # [s] since the board was made
    text: str
    style: str = ""


@dataclass
class Board:
    """Takes messages, knows the newest and their ages; :meth:`refresh` notes what has fallen silent."""

    start: int  # [ns]
    fingers: tuple[str, ...] = ()
    rows: dict[str, FingerRow] = field(default_factory=dict)
    nodes: dict[str, NodeRow] = field(default_factory=dict)
    log: deque[LogLine] = field(default_factory=lambda: deque(maxlen=LOG_LINES))
    said: int = 0  # lines of the log since the start
    counts: dict[str, int] = field(default_factory=dict)
    _limits: dict[str, str] = field(default_factory=dict)  # of each finger, as it was reported
    _slipping: set[str] = field(default_factory=set)
    _looked: int | None = None  # [ns]
    _awake_since: int = 0  # [ns]
    _ended: tuple[str, int] | None = None  # the node that has ended last, and when [ns]

    def __post_init__(self) -> None:
        self.rows = {finger: FingerRow() for finger in self.fingers}

    def receive(self, message: messages.Message, now: int, node: str = "") -> None:
        kind = type(message).__name__
        self.counts[kind] = self.counts.get(kind, 0) + 1
        speaker = message.node if isinstance(message, messages.OF_NODES) else node
        if speaker and (row := self._node(speaker, now)) is not None:
            row.receive(message, now)
        if isinstance(message, messages.OF_NODES):
            return
        if message.finger not in self.rows and len(self.rows) >= MOST_FINGERS:
            return
        finger = self.rows.setdefault(message.finger, FingerRow())
        finger.source = node
        if isinstance(message, messages.ForceCommand):
            if message.reason != messages.Reason.SLIP:
                self._slipping.discard(message.finger)
            elif message.finger not in self._slipping:
                self._slipping.add(message.finger)
                self.say(f"{message.finger}: slip detected, grip raised", now, "red")
        elif isinstance(message, messages.ModelHealth):
            self._log_limit(message, now)
            # :meth:`refresh` reports a change of condition, several fingers in one line
            if message.condition is finger.announced or (
                finger.announced is None and message.condition in ABSENT
            ):
                finger.pending = None
            elif finger.pending is None or finger.pending[0] is not message.condition:
                finger.pending = (message.condition, now)
        finger.put(message, now)

    def attend(self, present: Iterable[Present], now: int) -> None:
        """Note which nodes run on this machine, all of them, and their fingers in the order of the hand.

        Of those that have failed only what was on the board is noted.
        """
        known = {node.name: node for node in present}
        for name, node in known.items():
            if not node.failure:
                self._node(name, now)
                self._order(node.fingers)
        for name, row in self.nodes.items():
            row.attend(known.get(name), now)

    def refresh(self, now: int) -> None:
        """Log what has fallen silent, died, stopped or returned by ``now`` [ns]."""
        if self._looked is None or now - self._looked > FRESH * NS:
            self._awake_since = now  # a monitor that did not look must not call nodes silent
        self._looked = now
        for name, row in self.nodes.items():
            presence = row.judge(now, self._awake_since)
            if presence is not row.presence:
                before, row.presence = row.presence, presence
                self._log_presence(name, row, before, now)
        self._log_conditions(now)

    def say(self, text: str, now: int, style: str = "") -> None:
        self.said += 1
        self.log.append(LogLine((now - self.start) / NS, text, style))

    @property
    def busy(self) -> str:
        """One sentence when commands leave late because of this machine, else empty."""
        for name, row in self.nodes.items():
            if row.presence is Presence.RUNNING and row.late_share > BUSY:
                share = f"{100.0 * row.late_share:.0f} %"
                word = "too busy" if row.late_share >= TOO_BUSY else "busy"
                return f"this machine is {word}: {share} of the commands of {name} are late"
        return ""

    def _node(self, name: str, now: int) -> NodeRow | None:
        if name not in self.nodes and len(self.nodes) >= MOST_NODES:
            return None
        return self.nodes.setdefault(name, NodeRow(now, is_old=self._looked is None))

    def _order(self, fingers: Iterable[str]) -> None:
        new = tuple(finger for finger in fingers if finger not in self.fingers)
        if not new or len(self.fingers) + len(new) > MOST_FINGERS:
            return
        self.fingers += new
        self.rows = {finger: self.rows.get(finger, FingerRow()) for finger in self.fingers} | {
            finger: row for finger, row in self.rows.items() if finger not in self.fingers
        }

    def _log_presence(self, name: str, row: NodeRow, before: Presence, now: int) -> None:
        since = f"{(row.last_received - self.start) / NS:.1f} s"
        if row.presence in (Presence.GONE, Presence.STOPPED) and row.sends:
            self._ended = (name, now)
        match row.presence:
            case Presence.SILENT:
                self.say(f"{name} is silent since {since}", now, "bold red")
            case Presence.GONE:
                self.say(f"{name} has died, last received at {since}: {row.failure}", now, "bold red")
            case Presence.STOPPED:
                self.say(f"{name} has stopped", now)
            case Presence.STARTING:
                row.is_old = False
            case Presence.RUNNING if before is not Presence.STARTING:
                self.say(f"{name} is received again", now, "green")
            case Presence.RUNNING if not row.is_old:
                self.say(f"{name} has started", now)

    def _log_limit(self, health: messages.ModelHealth, now: int) -> None:
        before = self._limits.get(health.finger, "")
        if health.limit == before:
            return
        self._limits[health.finger] = health.limit
        if health.limit == messages.LIMIT_REACHED:
            self.say(f"{health.finger}: more is needed than the largest force", now, "red")
        elif health.limit == messages.LIMIT_NEAR and not before:
            self.say(
                f"{health.finger}: half as much load again needs more than the largest force", now, "yellow"
            )
        elif not health.limit:
            self.say(f"{health.finger}: the largest force suffices again", now, "green")

    def _log_conditions(self, now: int) -> None:
        due = {
            row.pending[0]
            for row in self.rows.values()
            if row.pending
            and (row.pending[0] > messages.Condition.MISSING or now - row.pending[1] > FRESH * NS)
        }
        for condition in sorted(due):
            changed = []
            for finger, row in self.rows.items():
                if row.pending is None or row.pending[0] is not condition or not self._speaks(row.source):
                    continue
                first, row.announced, row.pending = row.announced is None, condition, None
                if not (first and condition is messages.Condition.OK):
                    changed.append(finger)
            if changed:
                self._log_condition(changed, condition, now)

    def _log_condition(self, fingers: list[str], condition: messages.Condition, now: int) -> None:
        names = "all fingers" if len(fingers) == len(self.rows) > 1 else ", ".join(fingers)
        if condition in ABSENT and self._ended is not None and now - self._ended[1] < CONSEQUENCE * NS:
            self.say(f"{names}: no input since {self._ended[0]} stopped", now)
        else:
            self.say(f"{names}: input {words(condition)}", now, CONDITION_STYLE.get(condition, "red"))

    def _speaks(self, node: str) -> bool:
        return node not in self.nodes or self.nodes[node].presence is Presence.RUNNING


def words(name: messages.Condition | messages.Reason) -> str:
    return name.name.lower().replace("_", " ")


def as_json(board: Board, now: int) -> dict[str, object]:
    """Return what is on the board at ``now`` [ns] as JSON has it: no NaN, enumerations by name.

    Everything has its ``age`` [s]; what is not ``fresh`` says nothing of now.
    """
    fingers = {
        finger: {
            name: {
                **jsonable(asdict(message)),
                "age": row.age(kind, now),
                "fresh": row.fresh(kind, now) is not None,
            }
            for name, kind in MESSAGE_OF_TOPIC.items()
            if (message := row.newest(kind)) is not None
        }
        for finger, row in board.rows.items()
    }
    return {
        "fingers": fingers,
        "nodes": {
            name: {
                **jsonable(asdict(row.status) if row.status is not None else {}),
                "age": row.age(now),
                "presence": row.presence.value,
            }
            for name, row in board.nodes.items()
        },
    }
