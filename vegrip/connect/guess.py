"""What a signal of a foreign hand may measure, and at which finger: from names, units and messages."""

import itertools
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

from vegrip.errors import ConfigError
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.signals import Signal, folded
from vegrip.transport.maps.units import conversion

FINGER_WORDS: Final = {
    "thumb": ("thumb", "daumen", "th", "thb"),
    "index": ("index", "idx", "zeige", "forefinger", "ff", "zeigefinger"),
    "middle": ("middle", "mid", "mittel", "mf", "mittelfinger"),
    "ring": ("ring", "rf", "ringfinger"),
    "left": ("left", "l", "links"),
    "right": ("right", "r", "rechts"),
    "little": ("little", "pinky", "pinkie", "small", "lf", "klein"),
}
FINGER_NAMES: Final = frozenset(itertools.chain(*FINGER_WORDS.values()))
COMMAND_WORDS: Final = {
    "set",
    "cmd",
    "command",
    "target",
    "tgt",
    "ref",
    "desired",
    "des",
    "demand",
    "goal",
    "req",
    "request",
    "setpoint",
    "sp",
    "soll",
}
COUNTER_WORDS: Final = {"cnt", "counter", "alive", "rolling", "seq", "sequence", "rc", "msgcnt", "bz", "ctr"}
CHECKSUMS: Final = {"crc", "crc8", "crc16", "chk", "checksum", "chksum", "cs", "cksum", "bcc", "lrc", "check"}
FORCE_WORDS: Final = {"force", "frc", "load", "press", "pressure", "grip", "kraft", "f"}
NORMAL_WORDS: Final = {"normal", "norm", "fn", "fz", "grip", "press", "pressure", "normalkraft", "n", "z"}
SHEAR_WORDS: Final = {"shear", "fs", "tangential", "tang", "ft", "lateral", "quer"}
POSITION_WORDS: Final = {
    "depth",
    "indent",
    "indentation",
    "disp",
    "displacement",
    "deform",
    "deformation",
    "deflection",
    "pos",
    "position",
    "compression",
    "weg",
}
JOINT_WORDS: Final = {"angle", "joint", "q", "theta", "winkel", "pos", "position", "enc", "encoder"}
SLIP_WORDS: Final = {"slip", "slide", "sliding", "slipping", "rutsch"}
AXIS_WORDS: Final = {quantity + axis: axis for axis in "xyz" for quantity in ("", "f", "t", "m")}
UNIT_OF_DIMENSION: Final = {
    "force": "N",
    "torque": "N*m",
    "length": "m",
    "temperature": "degC",
    "current": "A",
    "speed": "m/s",
}
VECTOR_QUANTITIES: Final = ("force", "normal", "tangential", "torque")
"""How channels begin that are components of a vector."""

ANGLES: Final = {"deg", "rad", "°", "degree", "degrees", "mrad", "cdeg", "mdeg"}


MOST_FLAGS: Final = 4
"""Bits of a signal that may be flags or a mode."""


@dataclass(frozen=True, slots=True)
class Guess:
    """What one signal may be."""

    message: str
    signal: str
    finger: str  # "" = not reported
    channel: (
        str  # a channel, or "command", "counter", "checksum", "joint", "current", "force" of no known axis
    )
    certainty: float  # 0 .. 1
    why: str
    own: str  # its name without the letter or number of its finger

    @property
    def name(self) -> str:
        return f"{self.message}.{self.signal}"


def words_of(name: str) -> list[str]:
    """Return the words in a name, in lower case.

    >>> words_of("TipForceZ_Thumb2")
    ['tip', 'force', 'z', 'thumb', '2']
    """
    parts = re.findall(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+", folded(name))
    return [word.lower() for word in parts]


def quantity_of(unit: str) -> str:
    """Return what is measured in ``unit``: a key of ``UNIT_OF_DIMENSION``, "angle", or "" when unknown."""
    if unit.strip() in ANGLES:
        return "angle"
    if not unit.strip() or unit.strip() in ("%", "1", "-", "count", "counts", "bit", "LSB", "raw"):
        return ""
    for name, wanted in UNIT_OF_DIMENSION.items():
        try:
            conversion(unit, wanted, "unit")
        except ConfigError:
            continue
        return name
    return ""


def finger_of(message: str, signal: str, numbers: tuple[str, ...]) -> str:
    """Return the finger that is named, or numbered from 1 (0 where there is one), "" if none is."""
    for words in (words_of(signal), words_of(message)):
        for finger, names in FINGER_WORDS.items():
            if any(word in names for word in words):
                return finger
    for name in (signal, message):
        digits = [word for word in words_of(name) if word.isdecimal()]
        if digits and int(digits[0]) <= len(numbers) and numbers:
            return f"#{int(digits[0])}"
    return ""


def guesses(database: Database, numbers: tuple[str, ...] = ()) -> list[Guess]:
    return [one for one in all_signals(database, numbers) if one.channel]


def all_signals(database: Database, numbers: tuple[str, ...] = ()) -> list[Guess]:
    """Return what each signal may be; the channel of one that may be nothing is ""."""
    names: dict[tuple[str, str], Pattern] = {
        (message.name, signal): (tuple(words_of(message.name)), tuple(words_of(signal)))
        for message in database.messages.values()
        for signal in message.signals
    }
    kinds = {
        place: _kind(database.messages[place[0]].signals[place[1]], set(words[1]), set(words[0]))
        for place, words in names.items()
    }
    is_scalar = {
        names[place]: kind[0].partition("_")[0] not in VECTOR_QUANTITIES
        for place, kind in kinds.items()
        if kind
    }
    family = Family(is_scalar, FINGER_NAMES)
    found = []
    for (message, signal), kind in kinds.items():
        words = names[message, signal]
        member = family.member(words)
        own = [word for word in words[1] if not word.isdecimal() and word not in FINGER_NAMES]
        if member is None:
            finger = finger_of(message, signal, numbers)
        else:
            finger, own = f"#{member.finger}", [*member.pattern[0], *member.pattern[1]]
        channel, certainty, why = kind or ("", 0.0, "")
        found.append(Guess(message, signal, finger, channel, certainty, why, " ".join(own)))
    return sorted(found, key=lambda one: -one.certainty)


def _kind(  # noqa: PLR0911, PLR0912 (a list of questions, each with its answer)
    signal: Signal, words: set[str], around: set[str]
) -> tuple[str, float, str] | None:
    if words & CHECKSUMS:
        return "checksum", 0.9, "its name"
    if words & COUNTER_WORDS and not signal.is_float and signal.length <= 32:
        return "counter", 0.9, "its name"
    quantity = quantity_of(signal.unit)
    if words & COMMAND_WORDS or (around & COMMAND_WORDS and not words & COUNTER_WORDS):
        if quantity or words & (FORCE_WORDS | POSITION_WORDS | JOINT_WORDS):
            return "command", 0.8, "a name that says set, command or target"
        if words & COMMAND_WORDS and signal.length > MOST_FLAGS:
            return "command", 0.4, "a name that says set, command or target; no unit of force"
        return None
    axis = next((AXIS_WORDS[word] for word in sorted(words) if word in AXIS_WORDS), "")
    if words & SLIP_WORDS:
        speed = quantity == "speed"
        return ("slip_speed" if speed else "slip"), 0.8, "its name"
    if quantity == "force" or (
        not quantity
        and words & (FORCE_WORDS | SHEAR_WORDS | {"fx", "fy", "fz", "fn", "ft"})
        and (axis or words & ((FORCE_WORDS | SHEAR_WORDS) - {"f"}))
    ):
        return _force(words, axis, is_sure=quantity == "force")
    if quantity == "torque":
        return (f"torque_{axis or 'z'}", 0.8 if axis else 0.6, "a unit of torque")
    if quantity == "length":
        named = bool(words & POSITION_WORDS)
        return ("displacement", 0.9 if named else 0.4, "a unit of length")
    if quantity == "angle":
        return "joint", 0.7 if words & JOINT_WORDS else 0.4, "an angle"
    if quantity == "temperature":
        return "temperature", 0.9, "a unit of temperature"
    if quantity == "current":
        return "current", 0.7, "a current"
    if quantity == "speed":
        return "slip_speed", 0.2, "a unit of speed"
    if not quantity and words & ((POSITION_WORDS | {"enc", "encoder"}) - {"pos", "position"}):
        return "displacement", 0.3, "its name; no unit"
    return None


def _force(words: set[str], axis: str, *, is_sure: bool) -> tuple[str, float, str]:
    why = "a unit of force" if is_sure else "its name; no unit of force"
    weight = 1.0 if is_sure else 0.5
    if axis in ("x", "y") and not words & {"normal", "fn"}:
        return f"tangential_force_{axis}", 0.9 * weight, f"{why}, and {axis} in its name"
    if axis == "z" or words & (NORMAL_WORDS - {"z"}):
        return "normal_force", 0.9 * weight, f"{why}, and z, normal or grip in its name"
    if words & SHEAR_WORDS:
        return "tangential_force_x", 0.7 * weight, f"{why}, and shear in its name"
    return "force", 0.4 * weight, why


Words = tuple[str, ...]
Pattern = tuple[Words, Words]
"""The words of a message and of a signal, with ``*`` for the letter or number of the finger."""

FINGER: Final = "*"
AXES: Final = frozenset("xyz")
MIN_ALIKE: Final = 2  # names that two fingers must have in common
MOST_NUMBERED: Final = 5  # fingers; what is numbered further are joints or taxels


class Masked(NamedTuple):
    """A name with a letter or number taken out of its message, its signal or both."""

    mark: str
    words: frozenset[str]  # that the letter or number was taken out of
    pattern: Pattern


class Member(NamedTuple):
    """A finger, as its name shows it."""

    finger: int  # its place in the order of letters, or its number
    pattern: Pattern


class Family:
    """The fingers of a hand, by the words of its messages and signals.

    ``names`` says of each whether it is no component of a vector, ``all_fingers`` what alone names a finger.
    """

    def __init__(self, names: Mapping[Pattern, bool], all_fingers: frozenset[str]) -> None:
        self._others = all_fingers
        users: dict[Pattern, list[Masked]] = defaultdict(list)
        proven: set[Pattern] = set()
        for name, is_scalar in names.items():
            for one in _masked(name):
                users[one.pattern].append(one)
                if is_scalar or FINGER in "".join(one.pattern[0]):
                    proven.add(one.pattern)
        alike: dict[frozenset[str], set[Pattern]] = defaultdict(set)
        for pattern, found in users.items():
            alike[frozenset(one.mark for one in found)].add(pattern)
        words = {
            marks: frozenset().union(*(one.words for pattern in patterns for one in users[pattern]))
            for marks, patterns in alike.items()
        }
        possible = [
            marks
            for marks, patterns in alike.items()
            if len(patterns) >= MIN_ALIKE and patterns & proven and self._are_fingers(marks, words[marks])
        ]
        best = max(possible, key=lambda marks: (len(alike[marks]), sorted(marks)), default=frozenset())
        self._alike, self._words = alike[best], words.get(best, frozenset())
        self._numbers = {mark: n for n, mark in enumerate(sorted(best), start=1)}

    def member(self, name: Pattern) -> Member | None:
        """Return the finger of a name, None where it has none."""
        own = [one for one in _masked(name) if one.mark in self._numbers and one.words <= self._words]
        alike = [one for one in own if one.pattern in self._alike] or [
            one for one in own if not one.mark.isdecimal()
        ]
        if not alike or (self._others - self._words) & {*name[0], *name[1]}:
            return None
        best = max(alike, key=lambda one: [FINGER in "".join(part) for part in one.pattern])
        return Member(int(best.mark) if best.mark.isdecimal() else self._numbers[best.mark], best.pattern)

    def _are_fingers(self, marks: frozenset[str], words: frozenset[str]) -> bool:
        if len(marks) == 1 or words <= self._others or marks <= AXES:
            return False
        numbers = [int(mark) for mark in marks if mark.isdecimal()]
        return not numbers or (len(numbers) == len(marks) and max(numbers) <= MOST_NUMBERED)


def _masked(name: Pattern) -> Iterator[Masked]:
    """Yield the name without each number in it, and without each letter that begins or ends a word."""
    places: dict[str, tuple[list[tuple[str, Words]], ...]] = defaultdict(lambda: ([], []))
    for side, part in enumerate(name):
        for i, word in enumerate(part):
            ends: tuple[tuple[str, str], ...] = ((word, FINGER),)
            if not word.isdecimal():
                ends = tuple({word[0]: FINGER + word[1:], word[-1]: word[:-1] + FINGER}.items())
            for mark, left in ends:
                places[mark][side].append((word, (*part[:i], left, *part[i + 1 :])))
    for mark, (messages, signals) in places.items():
        for (one, message), (other, signal) in itertools.product(
            [("", name[0]), *messages], [("", name[1]), *signals]
        ):
            if words := frozenset((one, other)) - {""}:
                yield Masked(mark, words, (message, signal))
