"""What a node meets, apart from any wire; and the recordings of it that the cases share (``inputs.npz``).

The recordings are data, not computed anew: a change of the virtual hand or bus leaves them as they are.
"""

import functools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

PATH = Path(__file__).parent / "inputs.npz"
HAND = ("thumb", "index", "middle", "ring", "little")
CHANNELS = (
    "normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement", "temperature",
    "slip", "slip_speed", "contact_radius",
)  # fmt: skip
STEPS = np.array([2.0**-10, 2.0**-10, 2.0**-10, 2.0**-22, 2.0**-24, 2.0**-6, 1.0, 2.0**-20, 2.0**-22])
"""What a kept value is a whole multiple of [SI]: a tenth of the noise or less, exact in single precision."""
MISSING = np.iinfo(np.int32).min

STATE, FOREIGN, STOP, STALL, SETTINGS, CYCLE, END = range(7)
"""Kinds of events: a state; a message addressed to no one; the node is killed, and started at ``until``;
its computer stands still until then; it gets other settings; it is restarted; nothing comes any more."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happens at ``now`` [ns]; a state arrived at ``stamp``."""

    kind: int
    now: int
    stamp: int = 0
    finger: int = 0
    seq: int = 0
    sent: int = 0  # [ns] stamp of the sender
    values: tuple[float, ...] = ()  # of CHANNELS
    harm: int = 0  # 1 + number of the bit that is flipped on the way; -n: only n bytes arrive
    until: int = 0  # [ns]


@dataclass(frozen=True)
class Tape:
    """Events in the order of ``now``, and the fingers that they are of."""

    fingers: tuple[str, ...]
    events: tuple[Event, ...]

    def until(self, seconds: float) -> "Tape":
        """Return the beginning."""
        return Tape(self.fingers, tuple(event for event in self.events if event.now < seconds * 1e9))

    def with_events(self, more: Iterable[Event]) -> "Tape":
        """Return it with ``more`` events in their places."""
        return Tape(self.fingers, tuple(sorted((*self.events, *more), key=lambda event: event.now)))


WHOLE = ("kind", "now", "stamp", "finger", "seq", "sent", "harm", "until")


def save(tapes: Mapping[str, Tape], path: Path = PATH) -> None:
    """Keep ``tapes``; values are rounded to their ``STEPS``, columns kept as differences."""
    arrays = {}
    for name, tape in tapes.items():
        columns = [np.array([getattr(event, key) for event in tape.events], dtype=np.int64) for key in WHOLE]
        arrays[f"{name}/fingers"] = np.array(tape.fingers)
        values = np.array([event.values or (np.nan,) * len(CHANNELS) for event in tape.events])
        numbers = np.where(np.isnan(values), MISSING, np.rint(np.nan_to_num(values) / STEPS)).astype(np.int64)
        for key, column in (*zip(WHOLE, columns, strict=True), *zip(CHANNELS, numbers.T, strict=True)):
            arrays[f"{name}/{key}"] = _narrow(_differences(column, len(tape.fingers)))
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]


@functools.cache
def load(name: str) -> Tape:
    """Return the recording called ``name``."""
    with np.load(PATH) as kept:
        fingers = tuple(kept[f"{name}/fingers"].tolist())
        whole = [_sums(kept[f"{name}/{key}"], len(fingers)) for key in WHOLE]
        numbers = np.stack([_sums(kept[f"{name}/{key}"], len(fingers)) for key in CHANNELS], axis=1)
    values = np.where(numbers == MISSING, np.nan, numbers * STEPS)
    rows = zip(*(column.tolist() for column in whole), map(tuple, values.tolist()), strict=True)
    return Tape(fingers, tuple(_event(*row) for row in rows))


def names() -> Sequence[str]:
    """Return the names of the recordings."""
    with np.load(PATH) as kept:
        return sorted({key.rpartition("/")[0] for key in kept.files})


def _event(
    kind: int, now: int, stamp: int, finger: int, seq: int, sent: int, harm: int, until: int,
    values: tuple[float, ...],
) -> Event:  # fmt: skip
    return Event(kind, now, stamp, finger, seq, sent, values if kind == STATE else (), harm, until)


def _differences(column: np.ndarray, lag: int) -> np.ndarray:
    """Return each number less the one ``lag`` before it: that of the same finger, mostly."""
    out = column.copy()
    out[lag:] -= column[:-lag]
    return out


def _sums(differences: np.ndarray, lag: int) -> np.ndarray:
    out = differences.astype(np.int64)
    for first in range(lag):
        out[first::lag] = np.cumsum(out[first::lag])
    return out


def _narrow(column: np.ndarray) -> np.ndarray:
    for kind in (np.int8, np.int16, np.int32):
        if column.size == 0 or (np.iinfo(kind).min <= column.min() and column.max() <= np.iinfo(kind).max):
            return column.astype(kind)
    return column
