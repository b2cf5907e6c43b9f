"""The board: the newest message of every kind and finger, rates, and a short log. Pure; time is passed in."""

import math
from collections import deque
from dataclasses import asdict, dataclass, field

from vegrip.clock import NS
from vegrip.messages import (
    Condition,
    ContactEstimate,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)

STALE = 0.5  # [s] after which a row is shown as silent
LOG_LINES = 8
MOST_FINGERS = 64  # a sender of made-up names must not make the board grow


@dataclass
class Row:
    """What is known of one finger."""

    state: FingertipState | None = None
    contact: ContactEstimate | None = None
    margin: SlipMargin | None = None
    command: ForceCommand | None = None
    health: ModelHealth | None = None
    heard: int = 0  # [ns]

    def silent(self, now: int) -> bool:
        """Whether nothing has come for a while."""
        return now - self.heard > STALE * NS


@dataclass(frozen=True, slots=True)
class LogLine:
    """Something that happened."""

    time: float  # [s] since the board was made
    text: str
    style: str = ""


@dataclass
class Board:
    """Takes messages, knows the newest."""

    start: int  # [ns]
    fingers: tuple[str, ...] = ()
    rows: dict[str, Row] = field(default_factory=dict)
    nodes: dict[str, NodeStatus] = field(default_factory=dict)
    log: deque[LogLine] = field(default_factory=lambda: deque(maxlen=LOG_LINES))
    counts: dict[str, int] = field(default_factory=dict)
    _slipping: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.rows = {finger: Row() for finger in self.fingers}

    def take(self, message: Message, now: int) -> None:
        """Put ``message`` on the board."""
        kind = type(message).__name__
        self.counts[kind] = self.counts.get(kind, 0) + 1
        if isinstance(message, NodeStatus):
            self.nodes[message.node] = message
            return
        if message.finger not in self.rows and len(self.rows) >= MOST_FINGERS:
            return
        row = self.rows.setdefault(message.finger, Row())
        row.heard = now
        self._put(row, message, now)

    def say(self, text: str, now: int, style: str = "") -> None:
        """Add a line to the log."""
        self.log.append(LogLine((now - self.start) / NS, text, style))

    def _put(self, row: Row, message: Message, now: int) -> None:
        match message:
            case FingertipState():
                row.state = message
            case ContactEstimate():
                row.contact = message
            case SlipMargin():
                row.margin = message
            case ForceCommand():
                self._note_slip(message, now)
                row.command = message
            case ModelHealth():
                self._note_condition(row, message, now)
                row.health = message

    def _note_slip(self, command: ForceCommand, now: int) -> None:
        if command.reason != Reason.SLIP:
            self._slipping.discard(command.finger)
        elif command.finger not in self._slipping:
            self._slipping.add(command.finger)
            self.say(f"{command.finger}: slip felt, grip raised", now, "red")

    def _note_condition(self, row: Row, health: ModelHealth, now: int) -> None:
        before = row.health.condition if row.health is not None else Condition.OK
        if health.condition != before:
            style = "green" if health.condition == Condition.OK else "red"
            self.say(f"{health.finger}: input {words(health.condition)}", now, style)


def words(name: Condition | Reason) -> str:
    """Return an enumeration's name as words."""
    return name.name.lower().replace("_", " ")


def as_json(board: Board) -> dict[str, object]:
    """Return what is on the board as JSON has it: NaN and infinity as null, enumerations by name."""
    kinds = ("state", "contact", "margin", "command", "health")
    fingers = {
        finger: {
            kind: _jsonable(asdict(getattr(row, kind))) for kind in kinds if getattr(row, kind) is not None
        }
        for finger, row in board.rows.items()
    }
    return {
        "fingers": fingers,
        "nodes": {name: _jsonable(asdict(status)) for name, status in board.nodes.items()},
    }


def _jsonable(value: object) -> object:
    if isinstance(value, dict):
        return {key: _jsonable(item) for key, item in value.items()}
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return getattr(value, "name", value)
