"""Faults of the frames, of the stamps and of the values, drawn from a seed.

Frame faults replace or repeat bytes; what they carry is refused, or flagged, but never believed. Value faults
are wrong values of one channel, within the ranges, in sound frames.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from random import Random

from rig import PERIOD, Rig
from wires import FINGERS, LARGEST, QUANTITIES, Sent

BEGIN = 2.0  # [s] the grasp is at rest
SPREAD = 0.3  # [s] of the beginnings
DURATIONS = {"one": PERIOD, "ten": 10 * PERIOD, "1 s": 1.0}  # [s]
LONG = 0.2  # [s] a fault that lasts so long is told as a condition
HOUR = 3600 * 10**9  # [ns]
LONGEST_FD = 64  # [bytes]

STALE, MISSING, OUT_OF_RANGE = 2, 3, 4
Make = Callable[["Frames", int, int, dict[str, float]], Iterable[Sent]]


class Frames:
    """What a frame fault works with: the hand's wire, a source of randomness, and what went before."""

    def __init__(self, rig: Rig, pick: Random) -> None:
        self.rig, self.wire, self.pick = rig, rig.wire, pick
        self.kept: dict[int, list[Sent]] = defaultdict(list)

    def sound(self, finger: int, stamp: int, values: dict[str, float], **changes: int) -> Sent:
        return self.wire.state(finger, self.rig.next_seq(finger), stamp, values, **changes)

    def changed(self, finger: int, stamp: int, values: dict[str, float], value: float) -> list[Sent]:
        """Send with one quantity replaced."""
        name = self.pick.choice(("normal_force", "tangential_force_x", "torque_z", "displacement"))
        return [self.sound(finger, stamp, {**values, name: value})]


def flip(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Flip one to eight bits."""
    sent = f.sound(finger, stamp, values)
    data = bytearray(sent.data)
    for bit in f.pick.sample(range(8 * len(data)), f.pick.randint(1, 8)):
        data[bit // 8] ^= 1 << bit % 8
    return (sent._replace(data=bytes(data)),)


def truncate(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send the beginning, which may be nothing."""
    sent = f.sound(finger, stamp, values)
    lengths = (0, 1, 8, 12, 16, 24, 32) if f.wire.name == "can" else range(len(sent.data))
    return (sent._replace(data=sent.data[: f.pick.choice(list(lengths))]),)


def pad(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send more bytes than the message has."""
    sent = f.sound(finger, stamp, values)
    more = LONGEST_FD - len(sent.data) if f.wire.name == "can" else f.pick.choice((1, 100, 5000))
    return (sent._replace(data=sent.data + f.pick.randbytes(more)),)


def rubbish(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send random bytes in a burst."""
    sent = f.sound(finger, stamp, values)
    return [sent._replace(data=f.pick.randbytes(len(sent.data))) for _ in range(f.pick.randint(1, 20))]


def other_version(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Say another version, with a good checksum."""
    return (f.sound(finger, stamp, values, version=f.pick.choice((0, 2, 9, 255))),)


def wrong_data_id(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Protect the message as that of the other finger."""
    return (f.sound(finger, stamp, values, place_of=1 - finger),)


def others_name(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Name the other finger in a message that is protected well; CAN has no names, so the whole frame."""
    if f.wire.name == "can":
        return (f.sound(1 - finger, stamp, values)._replace(place=f.sound(finger, stamp, values).place),)
    return (f.sound(finger, stamp, values, named=1 - finger),)


def repeat(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send everything three times."""
    return (f.sound(finger, stamp, values),) * 3


def reverse(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send pairs to eights in reverse."""
    kept = f.kept[finger]
    kept.append(f.sound(finger, stamp, values))
    if len(kept) < 4:
        return ()
    late, f.kept[finger] = kept[::-1], []
    return late


def silence(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send nothing."""
    return ()


def nothing_measured(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send no quantity at all."""
    return (f.sound(finger, stamp, dict.fromkeys(values, math.nan)),)


def infinite(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send infinity."""
    return f.changed(finger, stamp, values, f.pick.choice((math.inf, -math.inf)))


def huge(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send the largest numbers of the wire."""
    return f.changed(finger, stamp, values, f.pick.choice((-1.0, 1.0)) * LARGEST[f.wire.name])


def out_of_range(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Send what no fingertip measures."""
    return f.changed(finger, stamp, values, f.pick.choice((-1.0, 1.0)) * 10.0 ** f.pick.uniform(2.0, 6.0))


def hour_off(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Stamp an hour before or after now."""
    return (f.sound(finger, stamp + f.pick.choice((-HOUR, HOUR)), values),)


def extreme_stamp(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Stamp with the ends of int64."""
    return (f.sound(finger, f.pick.choice((-(2**63), 2**63 - 1)), values),)


def impossible_stamp(f: Frames, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
    """Stamp beyond int64, which msgpack can carry."""
    return (f.sound(finger, f.pick.choice((2**63, 2**64 - 1)), values),)


@dataclass(frozen=True)
class Kind:
    """A frame fault and what has to be told of it: a name that is counted, or a condition; "" = none."""

    make: Make
    can: str | int = ""
    zmq: str | int = ""


KINDS = {
    "flipped bits": Kind(flip, "checksum", "checksum"),
    "truncated": Kind(truncate, "length", "checksum size"),
    "padded": Kind(pad, "length", "checksum size"),
    "rubbish": Kind(rubbish, "checksum", "checksum"),
    "other version": Kind(other_version, "version", "version"),
    "wrong Data ID": Kind(wrong_data_id, "checksum", "checksum"),
    "other finger's": Kind(others_name, "checksum", "finger"),
    "repeats": Kind(repeat, "counter", "counter"),
    "reversed": Kind(reverse, "counter", "counter"),
    "silence": Kind(silence, STALE, STALE),
    "nothing measured": Kind(nothing_measured, MISSING, MISSING),
    "infinite": Kind(infinite, "value", "value"),
    "huge": Kind(huge, OUT_OF_RANGE, OUT_OF_RANGE),
    "out of range": Kind(out_of_range, OUT_OF_RANGE, OUT_OF_RANGE),
    "an hour off": Kind(hour_off, "", ""),
    "ends of int64": Kind(extreme_stamp, "", ""),
    "beyond int64": Kind(impossible_stamp, "", "value"),
}

VALUES = {
    "normal_force": (-4.0, 59.0, 0.01),
    "displacement": (-9e-3, 9e-3, 5e-6),
    "tangential_force_x": (-59.0, 59.0, 0.01),
    "tangential_force_y": (-59.0, 59.0, 0.01),
    "torque_z": (-1.9, 1.9, 1e-4),
    "slip": (0.0, 1.0, 0.0),
    "slip_speed": (-0.5, 0.5, 5e-5),
    "temperature": (-20.0, 99.0, 0.05),
    "contact_radius": (1e-4, 8e-3, 1e-5),
}
"""Channel: least and largest wrong value within the ranges, noise."""
NOT_SENSED = ("contact_radius",)  # by this hand


@dataclass(frozen=True)
class Case:
    """One fault of one run."""

    wire: str
    what: str  # a kind of KINDS or a channel of VALUES
    begin: float  # [s]
    duration: float  # [s]
    fingers: tuple[int, ...]
    share: float  # [-] of the states that it meets
    value: float  # of a channel
    seed: int

    @property
    def of_values(self) -> bool:
        """Whether the frames are sound and a value is wrong."""
        return self.what in VALUES

    @property
    def end(self) -> float:
        """When it is over [s]."""
        return self.begin + self.duration

    def __str__(self) -> str:
        """Say it in a line."""
        what = f"{self.what} = {self.value:.3g}" if self.of_values else self.what
        who = " and ".join(FINGERS[finger] for finger in self.fingers)
        lasting = f"{1e3 * self.duration:.0f} ms from {self.begin:.3f} s"
        return f"{self.wire}: {what}, {100 * self.share:.0f} % of {who}, {lasting}"


def drawn(seed: int, kinds: Sequence[str] = (*KINDS, *VALUES)) -> Case:
    """Return the case of ``seed``: kinds in turn, then again on the other wire; the rest at random."""
    pick = Random(f"wire {seed}")
    what = kinds[seed % len(kinds)]
    low, high, _ = VALUES.get(what, (0.0, 0.0, 0.0))
    return Case(
        wire=("can", "zmq")[(seed + seed // len(kinds) * (1 - len(kinds) % 2)) % 2],
        what=what,
        begin=BEGIN + PERIOD * pick.randrange(round(SPREAD / PERIOD)),
        duration=pick.choice(list(DURATIONS.values())),
        fingers=pick.choice(((0,), (1,), (0, 1))),
        share=1.0 if what in VALUES else pick.choice((1.0, 1.0, 0.5, 0.1)),
        value=pick.choice((low, high, pick.uniform(low, high), 0.02 * pick.uniform(low, high))),
        seed=seed,
    )


class Injection:
    """A case at work on a rig; :attr:`met` counts the states that it changed."""

    def __init__(self, case: Case, rig: Rig) -> None:
        self.case, self.rig, self.met = case, rig, 0
        self._pick = Random(case.seed)
        self._frames = Frames(rig, self._pick)

    def __call__(self, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
        """Return what goes out for a state."""
        case = self.case
        inside = case.begin - 1e-9 <= self.rig.now < case.end - 1e-9
        if not inside or finger not in case.fingers or self._pick.random() >= case.share:
            return self.rig.sound(finger, stamp, values)
        self.met += 1
        if case.of_values:
            wrong = case.value + self._pick.gauss(0.0, VALUES[case.what][2])
            return self.rig.sound(finger, stamp, {**values, case.what: wrong})
        return KINDS[case.what].make(self._frames, finger, stamp, values)


assert set(VALUES) == set(QUANTITIES)
