"""Which cases there are.

Every wire meets every setting undisturbed and with a hostile seed; every fault meets every wire and setting.

``quick`` are those that CI runs: every wire and setting undisturbed, some seeds and faults.
"""

import functools
from collections.abc import Iterator
from dataclasses import dataclass

from validation.golden import events
from validation.golden.events import CYCLE, SETTINGS, Event, Tape
from validation.golden.falsify import falsified
from validation.golden.settings import SETTINGS as OF_NODE
from validation.golden.settings import Setting
from validation.golden.wires import WIRES

BY_MESSAGES = ("messages", "replay")
ALL_WIRES = (*WIRES, *BY_MESSAGES)
SEEDS = range(20)
FAULT = "fault: "
HOSTILE_S, QUICK_S = (
    3.0,
    1.6,
)  # [s] of the recording that is made false; of that which is met undisturbed, quickly
MS = 1_000_000  # [ns]
QUICK_SETTINGS = ("default", "learning", "cone")
QUICK_SEEDS = (
    ("fd", 100), ("fd", 101), ("classic", 101), ("canopen", 102), ("packet", 103), ("topics", 103),
    ("batch", 104), ("map", 104),
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """What one node meets."""

    wire: str
    setting: str
    what: str  # "undisturbed", "changes", "seed 3", "fault: ..."
    is_quick: bool = False

    @property
    def name(self) -> str:
        """Return its name in the file."""
        return f"{self.wire}, {self.setting}, {self.what}"

    @property
    def seed(self) -> int | None:
        """Return the seed of what is made false in bytes, None where events are."""
        number = int(self.what.removeprefix("seed ")) if self.what.startswith("seed ") else 0
        return number if number % 2 and WIRES.get(self.wire) in _WITH_LIARS else None

    def tape(self) -> Tape:
        """Return what the node meets."""
        return _tape(self.what, OF_NODE[self.setting].tape, self.seed is not None)


_WITH_LIARS = [WIRES[name] for name in ("fd", "classic", "canopen", "packet", "topics")]


@functools.cache
def _tape(what: str, recording: str, is_false_in_bytes: bool) -> Tape:
    if what.startswith(FAULT):
        before, after = events.load("pinch"), events.load(what)
        return Tape(before.fingers, before.events + after.events)
    if what.startswith("seed "):
        tape = events.load(recording).until(HOSTILE_S)
        return tape if is_false_in_bytes else falsified(tape, int(what.removeprefix("seed ")))
    if what == "short":
        return events.load(recording).until(QUICK_S)
    tape = events.load(recording)
    if what != "changes":
        return tape
    return tape.with_events(
        [
            Event(SETTINGS, 1303 * MS),
            Event(CYCLE, 2203 * MS, until=2233 * MS),
            Event(CYCLE, 3103 * MS, until=3303 * MS),
        ]
    )


def fits(wire: str, setting: Setting) -> bool:
    """Return whether a wire can be set so."""
    if wire in BY_MESSAGES:
        is_of_endpoint = setting.order_window or setting.estimate_clock or setting.sender_time
        return not is_of_endpoint or (wire == "messages" and bool(setting.sender_time))
    kind = WIRES[wire]
    return (
        (kind.has_order or not setting.order_window)
        and (kind.has_clock or not setting.estimate_clock)
        and (kind.has_sender or setting.sender_time is None)
    )


def faults() -> list[str]:
    """Return the faults of the table, as they were recorded."""
    return [name for name in events.names() if name.startswith(FAULT)]


def is_small(fault: str) -> bool:
    """Return whether a fault is hardly seen by the node that grips; one wire meets it."""
    return fault.removeprefix(FAULT).startswith(("1 % of", "10 % of all states", "a subscriber", "disk full"))


def cases() -> Iterator[Case]:
    """Yield all cases."""
    usable = {name: [wire for wire in ALL_WIRES if fits(wire, one)] for name, one in OF_NODE.items()}
    pairs = [(wire, setting) for setting, wires in usable.items() for wire in wires]
    for number, (wire, setting) in enumerate(pairs):
        yield Case(wire, setting, "undisturbed")
        yield Case(wire, setting, f"seed {SEEDS[number % len(SEEDS)]}")
        if setting in QUICK_SETTINGS or wire in ("fd", "map"):
            yield Case(wire, setting, "short", wire in ("fd", "map", "canopen", "topics"))
        if setting in QUICK_SETTINGS:
            yield Case(wire, setting, "changes")
    for number, what in enumerate(faults()):
        if is_small(what):
            yield Case(ALL_WIRES[number % len(ALL_WIRES)], "default", what)
            continue
        free = set(ALL_WIRES)
        for turn, (setting, wires) in enumerate(usable.items(), number):
            left = [wire for wire in wires if wire in free] or wires
            wire = left[turn % len(left)]
            free.discard(wire)
            yield Case(wire, setting, what, setting == "default" and number % 3 == 0)
        for wire in sorted(free):  # so that each wire meets each fault
            yield Case(wire, "default", what)
    yield from (Case(wire, "default", f"seed {seed}", True) for wire, seed in QUICK_SEEDS)
