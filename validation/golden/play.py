"""Lets a node live through the events of a case in its real loop, and keeps what it said."""

import gc
import hashlib
import itertools
import logging
import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from typing import Any

from validation.golden.events import CYCLE, END, SETTINGS, STALL, STATE, STOP, Event, Tape
from validation.golden.settings import Setting, changed, make_node
from validation.golden.wires import WIRES, Wire, state_of
from validation.golden.world import World, present
from vegrip.clock import SimulatedClock
from vegrip.grip.controller import GripController
from vegrip.grip.node import GraspForce
from vegrip.grip.policies import POLICIES
from vegrip.messages import OF_NODES, Condition, ContactEstimate, ForceCommand, Message
from vegrip.runtime.replay.run import RecordedBus
from vegrip.runtime.runner import LoopSettings, Runner

TICK_S = 0.005
SILENCE_NS = 1_200_000_000  # [ns] after the last event: the fail-safe, and a last status
US = 1000  # [ns] to which times are told: a wait may end a nanosecond later
PLAYS_FROZEN = 25
_plays = itertools.count()
LOOP = LoopSettings(tick_period=TICK_S, status_period=0.5, deadline=10.0)  # no answer is late
CHANGED: dict[str, Any] = {
    "report_period": 0.011,
    "health_period": 0.13,
    "grip": {"wanted_margin": 0.25, "probability": 0.9, "release_time": 0.1},
    "limits": {"max_force": 9.0, "lifetime": 0.04},
    "watchdog": {"time_out": 0.03},
    "friction": {"scale": 1.0},
}
"""What another setting changes while the node runs."""


@dataclass
class Answers:
    """What was said and counted; each line is one answer, numbers to nine significant digits."""

    commands: dict[str, list[str]] = field(default_factory=dict)  # by finger
    reports: dict[str, list[str]] = field(default_factory=dict)  # by kind and finger
    conditions: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    streams: dict[str, Any] = field(default_factory=dict)  # SHA-256 of the bytes of each identifier or topic
    forces: list[float] = field(default_factory=list)
    friction: float = math.nan
    path: str = ""

    def said(self, at: int, message: Message) -> None:
        """Keep what was said at ``at`` [ns]."""
        if isinstance(message, ForceCommand):
            self.forces.append(message.normal_force)
            self.commands.setdefault(message.finger, []).append(f"{at // US} {text(message)}")
        elif not isinstance(message, OF_NODES):
            if isinstance(message, ContactEstimate):
                self.friction = message.friction_coefficient.value
            stream = f"{type(message).__name__} {message.finger}"
            self.reports.setdefault(stream, []).append(text(message))

    def sent(self, at: int, stream: str, data: bytes) -> None:
        """Keep the bytes that left, but for the status of the node, which is counted."""
        if stream == "/diagnostics":
            return
        self.streams.setdefault(stream, hashlib.sha256()).update((at // US).to_bytes(8, "little") + data)


def text(value: Any) -> str:
    """Return numbers and names in a value: real numbers to nine significant digits."""
    if isinstance(value, bool) or value is None:
        return str(int(value or 0))
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, float):
        return f"{value:.9g}"
    if is_dataclass(value):
        rest = " ".join(text(getattr(value, one.name)) for one in fields(value))
        return f"{type(value).__name__} {rest}" if hasattr(value, "stamp") else rest
    return str(value)


class _Session:
    """A node, its loop and its endpoint; started again where it is killed."""

    def __init__(self, wire: Wire, setting: Setting, way: str) -> None:
        self.wire, self._setting, self._way = wire, setting, way
        self.totals: dict[str, int] = defaultdict(int)
        self.node: GraspForce
        self.runner: Runner

    def start(self, world: World) -> None:
        """Open the endpoint and start the node; no time passes meanwhile."""
        world.stands = True
        self.endpoint: Any = self.wire.open()
        if self._way == "objects":
            self.endpoint.brings = ""
        self.node = make_node(self._setting, self.wire.fingers)
        if self._way in ("c", "numba", "python"):
            run, way = self.node.run_compiled, self._way
            self.node.run_compiled = lambda lines, _="": run(lines, way)  # type: ignore[method-assign,assignment]
        self.runner = Runner(self.node, self.endpoint, world, LOOP)
        self.runner.start()
        world.stands = False

    def end(self) -> None:
        """Close the endpoint, and add what was counted."""
        status = self.runner.status
        self.wire.collect()
        if status is not None:
            for name, count in status.rejected.items():
                self.totals[name] += count
        statistics = self.runner.statistics
        self.totals["states"] += statistics.states
        self.totals["commands"] += statistics.commands
        for name, finger in self.node.fingers.items():
            for condition, count in finger.faults.items():
                if count:
                    self.totals[f"{name} {condition.name}"] += count
        self.wire.close(self.endpoint)
        POLICIES.pop("golden", None)

    def conditions(self) -> tuple[int, ...]:
        """Return what is wrong with the input of each finger."""
        return tuple(condition_of(self.node, name) for name in self.wire.fingers)

    def happen(self, event: Event, world: World) -> bool:
        """Do what happens to the node; return whether it goes on."""
        if event.kind == STOP:
            self.end()
            world.drop(event.until)
            self.start(world)
        elif event.kind == STALL:
            world.sleep_until(event.until)
        elif event.kind == SETTINGS:
            self.node.parameters = changed(self.node.parameters, CHANGED)
        elif event.kind == CYCLE:
            self.runner.change("deactivate")
            world.sleep_until(event.until)
            self.runner.change("activate")
        return event.kind != END


def condition_of(node: GraspForce, name: str) -> int:
    """Return the condition of the input of a finger."""
    return int(node.fingers[name].condition)


def play(wire: str, setting: Setting, tape: Tape, seed: int | None = None, way: str = "") -> Answers:
    """Return what a node answers on a ``wire``.

    Args:
        wire: one of ``WIRES``, ``messages`` or ``replay``.
        setting: of the node.
        tape: what it meets.
        seed: of what is made false on this wire; None: nothing.
        way: ``objects``, or what runs the compiled step: ``c``, ``numba``, ``python``; empty: as by itself.

    """
    logging.disable(logging.CRITICAL)
    last = tape.events[-1].now + SILENCE_NS
    try:
        if wire == "messages":
            return _by_controller(setting, tape, last)
        if wire == "replay":
            return _replayed(setting, tape)
        return _on_wire(
            WIRES[wire](tape.fingers, setting), setting, tape.with_events([Event(END, last)]), seed, way
        )
    finally:
        logging.disable(logging.NOTSET)
        if next(_plays) % PLAYS_FROZEN == 0:
            gc.unfreeze()  # the loop freezes what there is; to look through all of it takes 0.3 s


def _on_wire(wire: Wire, setting: Setting, tape: Tape, seed: int | None, way: str) -> Answers:
    items = wire.items(tape.events)
    if seed is not None:
        items = wire.falsified(items, seed)
    answers, session = Answers(), _Session(wire, setting, way)
    with present(World(items, wire.deliver)) as world:
        session.start(world)
        answers.path = session.node.path_taken
        before: tuple[int, ...] = ()
        goes_on = True
        while goes_on:
            session.runner.step()
            wire.collect()
            if (item := world.happening()) is not None:
                goes_on = session.happen(item.thing, world)
            now = session.conditions()
            if now != before:
                before = now
                answers.conditions.append(
                    f"{world.time // US} {' '.join(Condition(one).name for one in now)}"
                )
        session.end()
    for sent in wire.sent:
        answers.sent(*sent)
    for at, message in wire.decoded(wire.sent):
        answers.said(at, message)
    answers.counts = dict(session.totals)
    return answers


def _by_controller(setting: Setting, tape: Tape, last: int) -> Answers:
    """Return what the controller without a bus answers."""
    made = make_node(setting, tape.fingers)
    controller = GripController(tape.fingers, settings=made.parameters, make_estimator=made._make_estimator)
    answers, tick = Answers(), 0
    faults = 0

    def step(states: list[Any], now: int) -> None:
        nonlocal faults
        try:
            for command in controller.step(states, now):
                answers.said(now, command)
        except ZeroDivisionError:  # of the policy that fails
            faults += 1

    before: tuple[int, ...] = ()
    for number, event in enumerate((*tape.events, Event(END, last))):
        while tick <= event.now:
            step([], tick)
            tick += round(TICK_S * 1e9)
        if event.kind == STATE and not event.harm:
            stamped = event.sent if setting.sender_time else event.stamp
            step([replace(state_of(event, tape.fingers), stamp=stamped)], event.now)
            if number % 5 == 0:
                name = tape.fingers[event.finger]
                for told in (controller.contact(name), controller.margin(name), controller.health(name)):
                    answers.said(event.now, told)
        elif event.kind == SETTINGS:
            controller.settings = changed(controller.settings, CHANGED)
        elif event.kind in (CYCLE, STOP):
            controller.reset()
        now = (
            tuple(int(controller.health(name).condition) for name in tape.fingers)
            if number % 5 == 0
            else before
        )
        if now != before:
            before = now
            answers.conditions.append(f"{event.now // US} {' '.join(Condition(one).name for one in now)}")
    answers.counts = {**controller.rejected, "fault ZeroDivisionError": faults}
    answers.path = "messages"
    return answers


def _replayed(setting: Setting, tape: Tape) -> Answers:
    """Return what a node answers to the states as a recording, in the loop of ``vegrip replay``."""
    answers, clock = Answers(), SimulatedClock()
    node = make_node(setting, tape.fingers)

    def states() -> Iterator[Any]:
        for event in tape.events:
            if event.kind == STATE and not event.harm:
                yield replace(state_of(event, tape.fingers), stamp=event.now)

    bus = RecordedBus(states(), tape.fingers, clock, lambda message: _kept(answers, clock, message))
    runner = Runner(node, bus, clock, LOOP)
    runner.start()
    answers.path = node.path_taken
    while not bus.finished:
        runner.step()
    runner.change("shutdown")
    answers.counts = {**bus.rejected, **runner.managed.faults, "states": runner.statistics.states}
    answers.conditions = _joined({k: v for k, v in answers.reports.items() if k.startswith("ModelHealth")})
    return answers


def _kept(answers: Answers, clock: SimulatedClock, message: Message) -> None:
    if type(message).__name__ != "FingertipState":
        answers.said(clock.now(), message)


def _joined(streams: Mapping[str, list[str]]) -> list[str]:
    """Return the lines of all streams: in which order those of different ones left does not matter."""
    return [line for name in sorted(streams) for line in streams[name]]


def lines_of(answers: Answers) -> dict[str, list[str]]:
    """Return what the digests are of, by their names."""
    return {
        "commands": _joined(answers.commands),
        "reports": _joined(answers.reports),
        "conditions": answers.conditions,
        "counts": [f"{name} {count}" for name, count in sorted(answers.counts.items()) if count],
        "bytes": [f"{stream} {found.hexdigest()[:16]}" for stream, found in sorted(answers.streams.items())],
    }


def numbers_of(answers: Answers) -> dict[str, float | int | list[float]]:
    """Return a few plain numbers, to judge a difference by eye or within a tolerance."""
    forces = [force for force in answers.forces if math.isfinite(force)]
    eighth = max(1, len(forces) // 8)
    means = [sum(part) / len(part) for i in range(8) if (part := forces[i * eighth : (i + 1) * eighth])]
    return {
        "commands": len(answers.forces),
        "reports": sum(map(len, answers.reports.values())),
        "changes": len(answers.conditions),
        "force": [float(f"{mean:.6g}") for mean in means],  # [N] mean of each eighth of the commands
        "most": float(f"{max(forces, default=0.0):.6g}"),  # [N]
        "friction": float(f"{answers.friction:.6g}"),  # as told last
    }
