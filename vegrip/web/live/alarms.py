"""What a person should notice now: worked out from the board, held long enough to be seen. Pure.

What is wrong with several fingers alike is one alarm that names them.
"""

import math
from dataclasses import dataclass, field
from enum import Enum

from vegrip import messages
from vegrip.clock import NS
from vegrip.runtime.monitor.board import Board, words
from vegrip.runtime.monitor.rows import FingerRow, Presence

REASONS = {
    messages.Reason.HOLD: "holds: the force suffices",
    messages.Reason.RAISE: "raises: the margin is below its target",
    messages.Reason.LOWER: "lowers: less force suffices",
    messages.Reason.SLIP: "raises: slip is felt",
    messages.Reason.FORECAST: "raises: the relaxing contact would slip soon",
    messages.Reason.RATE_LIMIT: "changes as fast as the limit allows",
    messages.Reason.MIN_LIMIT: "at the least force allowed",
    messages.Reason.MAX_LIMIT: "at the largest force allowed",
    messages.Reason.INPUT_HOLD: "holds the last safe force: bad input",
    messages.Reason.FAIL_SAFE: "goes to the fail-safe grip: bad input for long",
    messages.Reason.UNTRUSTED: "never below the last safe force: the estimate is not valid",
    messages.Reason.INACTIVE: "no control: the node is not active",
}
CONDITIONS = {
    messages.Condition.OK: "input ok",
    messages.Condition.DEGRADED: "a channel is missing",
    messages.Condition.STALE: "no input of late",
    messages.Condition.MISSING: "no input yet",
    messages.Condition.OUT_OF_RANGE: "input out of range",
    messages.Condition.FROZEN: "input frozen",
    messages.Condition.REPLAYED: "input replayed",
    messages.Condition.CORRUPT: "input corrupt",
}

LIMIT = {
    messages.LIMIT_NEAR: "half as much load again needs more than the largest force allowed",
    messages.LIMIT_REACHED: "more is needed than the largest force allowed: the margin is not kept",
}
"""Whether the largest force suffices, by :attr:`vegrip.messages.ModelHealth.limit`."""
FRICTION = {
    messages.PROBED: "probing friction: lowered slowly on purpose",
    messages.KNOWN: "friction is known: held with little more than the least force on purpose",
}
"""What is done on purpose, by :attr:`vegrip.messages.ModelHealth.friction`."""


def health_in_words(health: messages.ModelHealth) -> str:
    """Return whether the model explains what is measured, where it fails, and what it may lack."""
    if health.regime == messages.BEYOND_FIT:
        return f"{health.channel.replace('_', ' ')} is beyond the range over which the model was fitted"
    if health.consistent:
        return "the model explains what is measured"
    if not health.channel:
        return "not judged yet"
    text = f"the model does not explain {health.channel.replace('_', ' ')}"
    if health.regime:
        text += f" in {health.regime}"
    if health.suspect == "unexplained":
        return text + "; no known effect explains it"
    return text + (f"; suspect: {health.suspect.replace('_', ' ')}" if health.suspect else "")


ALARM_HOLD_S = 2.0  # [s] an alarm stays after its cause has gone
SOON = 1.0  # [s] until the earliest slip from which on it is an alarm


class Level(Enum):
    """How bad it is."""

    BAD = "bad"
    WARN = "warn"
    CALM = "calm"
    """Nothing is wrong: it is done on purpose."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """One thing to notice."""

    key: str  # the same while it lasts, whatever its numbers are
    level: Level
    text: str
    finger: str = ""  # that the text is about, "" = the text says it
    label: str = ""  # in a word or two, for the card of the finger


@dataclass
class Alarms:
    """Alarms as they come and go."""

    _held: dict[str, tuple[Alarm, int, int]] = field(default_factory=dict)  # alarm, first and last seen [ns]

    @property
    def held(self) -> list[Alarm]:
        return [alarm for alarm, _, _ in self._held.values()]

    def update(self, active: list[Alarm], now: int) -> list[dict[str, object]]:
        """Return what is to be shown at ``now`` [ns], the worst first, each with the seconds it lasts."""
        for alarm in active:
            first = self._held[alarm.key][1] if alarm.key in self._held else now
            self._held[alarm.key] = (alarm, first, now)
        self._held = {key: one for key, one in self._held.items() if now - one[2] <= ALARM_HOLD_S * NS}
        groups: dict[tuple[bool, str], list[tuple[Alarm, int, int]]] = {}
        for one in sorted(self._held.values(), key=lambda one: one[1]):
            alarm = one[0]
            groups.setdefault((alarm.level is Level.WARN, alarm.text), []).append(one)
        return [_shown(group, now) for _, group in sorted(groups.items(), key=lambda item: item[0][0])]


def _shown(group: list[tuple[Alarm, int, int]], now: int) -> dict[str, object]:
    fingers = ", ".join(alarm.finger for alarm, _, _ in group if alarm.finger)
    alarm, first, _ = group[0]
    text = f"{fingers}: {alarm.text}" if fingers else alarm.text
    return {"level": alarm.level.value, "text": text, "lasts": round((now - first) / NS)}


def alarms_of(board: Board, now: int) -> list[Alarm]:
    """Return what is wrong at ``now`` [ns]."""
    found = []
    for name, node in board.nodes.items():
        has_run = node.status is not None and node.status.state is not messages.Lifecycle.FINALIZED
        if node.presence is Presence.SILENT or (node.presence is Presence.GONE and has_run):
            said = "says nothing" if node.presence is Presence.SILENT else f"has died ({node.failure})"
            found.append(Alarm(f"node {name}", Level.BAD, f"{name} {said}; the last numbers are old"))
    if board.busy:
        found.append(Alarm("busy", Level.WARN, board.busy))
    for name, row in board.rows.items():
        if row.source not in board.nodes or board.nodes[row.source].presence is Presence.RUNNING:
            found += _of_finger(name, row, now)
    return found


def _of_finger(name: str, row: FingerRow, now: int) -> list[Alarm]:
    said = row.now(now)
    margin, command, contact, health = said.margin, said.command, said.contact, said.health
    found = []
    if health is not None and health.condition > messages.Condition.DEGRADED:
        text = CONDITIONS[health.condition]
        found.append(Alarm(f"input {name}", Level.BAD, text, name, text))
    if command is not None and command.reason is messages.Reason.SLIP:
        found.append(Alarm(f"slip {name}", Level.BAD, "slip is felt, the grip is raised", name, "slips"))
    if contact is not None and contact.in_contact and margin is not None and not said.lets_go:
        found += _of_margin(name, margin)
    if health is not None and health.limit in LIMIT:
        text = LIMIT[health.limit]
        found.append(Alarm(f"limit {name}", Level.WARN, text, name, f"limit {health.limit}"))
    elif command is not None and command.reason in (messages.Reason.MAX_LIMIT, messages.Reason.FAIL_SAFE):
        found.append(Alarm(f"limit {name}", Level.WARN, REASONS[command.reason], name, words(command.reason)))
    if health is not None and health.channel and not health.consistent:
        found.append(Alarm(f"health {name}", Level.WARN, health_in_words(health), name, "misfit"))
    return found


def states_of(board: Board, now: int) -> list[Alarm]:
    """Return what fingers do on purpose at ``now`` [ns] that would be alarming otherwise."""
    found = []
    for name, row in board.rows.items():
        said = row.now(now)
        if said.margin is not None and (text := FRICTION.get(said.friction)):
            found.append(Alarm(f"friction {name}", Level.CALM, text, name))
    return found


def _of_margin(name: str, margin: messages.SlipMargin) -> list[Alarm]:
    if margin.margin.valid and margin.lower_bound < 0.0:
        text = "may be slipping: the lower bound of the margin is below zero"
        return [Alarm(f"bound {name}", Level.BAD, text, name, "may slip")]
    if math.isfinite(margin.earliest_slip) and margin.earliest_slip < SOON:
        text = f"may slip within {SOON:g} s if the grip stays as it is"
        return [Alarm(f"soon {name}", Level.WARN, text, name, "may slip soon")]
    return []
