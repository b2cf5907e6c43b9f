"""What a person should notice now: worked out from the board, held long enough to be seen. Pure.

What is wrong with several fingers alike is one alarm that names them.
"""

import math
from dataclasses import dataclass, field
from enum import Enum

from vegrip.clock import NS
from vegrip.messages import (
    Condition,
    Lifecycle,
    Reason,
    SlipMargin,
)
from vegrip.runtime.monitor.board import Board, words
from vegrip.runtime.monitor.rows import FingerRow, Presence
from vegrip.web.live.words import CONDITIONS, FRICTION, REASONS, health_in_words

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
        """Those that are shown."""
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
        has_run = node.status is not None and node.status.state is not Lifecycle.FINALIZED
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
    if health is not None and health.condition > Condition.DEGRADED:
        text = CONDITIONS[health.condition]
        found.append(Alarm(f"input {name}", Level.BAD, text, name, text))
    if command is not None and command.reason is Reason.SLIP:
        found.append(Alarm(f"slip {name}", Level.BAD, "slip is felt, the grip is raised", name, "slips"))
    if contact is not None and contact.in_contact and margin is not None and not said.lets_go:
        found += _of_margin(name, margin)
    if command is not None and command.reason in (Reason.MAX_LIMIT, Reason.FAIL_SAFE):
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


def _of_margin(name: str, margin: SlipMargin) -> list[Alarm]:
    if margin.margin.valid and margin.lower_bound < 0.0:
        text = "may be slipping: the lower bound of the margin is below zero"
        return [Alarm(f"bound {name}", Level.BAD, text, name, "may slip")]
    if math.isfinite(margin.earliest_slip) and margin.earliest_slip < SOON:
        text = f"may slip within {SOON:g} s if the grip stays as it is"
        return [Alarm(f"soon {name}", Level.WARN, text, name, "may slip soon")]
    return []
