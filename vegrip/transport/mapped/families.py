"""Which finger a signal is of where names differ by one letter or number: FA_State.FA_Fz, FB_State.FB_Fz.

The names of a database are cut into words. Words that differ in their first or last letter, or that are
numbers, and that can stand for each other in several names, tell the fingers; those that can in most names
win. An axis is a letter too, so the name of a message must bear the letter, or a name that is of no vector.
"""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

Words = tuple[str, ...]
Pattern = tuple[Words, Words]
"""The words of a message and of a signal, with ``*`` for the finger."""

FINGER: Final = "*"
NUMBERED: Final = "#"
AXES: Final = frozenset("xyz")
MIN_ALIKE: Final = 2  # names that two fingers must have in common
MOST_NUMBERED: Final = 5  # fingers; what is numbered further are joints or taxels


class Member(NamedTuple):
    """What a name says of its finger."""

    finger: int  # its place in the order of letters, or its number
    pattern: Pattern


class Family:
    """The fingers of a hand.

    Args:
        names: words of message and signal, and whether the signal is no component of a vector.
        all_fingers: words that tell a finger by themselves.

    """

    def __init__(self, names: Mapping[Pattern, bool], all_fingers: frozenset[str]) -> None:
        self._others = all_fingers
        users: dict[tuple[str, Pattern], set[str]] = defaultdict(set)
        scalar: set[tuple[str, Pattern]] = set()
        for name, is_scalar in names.items():
            for kind, word, pattern in _patterns(name):
                users[kind, pattern].add(word)
                scalar |= {(kind, pattern)} if is_scalar else set()
        support: Counter[tuple[str, frozenset[str]]] = Counter()
        proven: set[tuple[str, frozenset[str]]] = set()
        for (kind, pattern), words in users.items():
            family = kind, frozenset(words)
            support[family] += 1
            if FINGER in pattern[0] or (kind, pattern) in scalar:
                proven.add(family)
        possible = [one for one in proven if support[one] >= MIN_ALIKE and self._are_fingers(*one)]
        best = max(possible, key=lambda one: (support[one], sorted(one[1])), default=("", frozenset()))
        self._kind, self._words = best
        self._alike = {
            pattern for (kind, pattern), words in users.items() if (kind, frozenset(words)) == best
        }
        self._numbers = {word: n for n, word in enumerate(sorted(self._words), start=1)}

    def member(self, name: Pattern) -> Member | None:
        """Return the finger of a name, None where it has none."""
        own = [(word, p) for kind, word, p in _patterns(name) if kind == self._kind and word in self._words]
        alike = [one for one in own if one[1] in self._alike] or own * (self._kind != NUMBERED)
        if not alike or (self._others - self._words) & {*name[0], *name[1]}:
            return None
        word, pattern = max(alike, key=lambda one: (FINGER in one[1][0], FINGER in one[1][1]))
        return Member(int(word) if word.isdecimal() else self._numbers[word], pattern)

    def _are_fingers(self, kind: str, words: frozenset[str]) -> bool:
        if len(words) == 1 or words <= self._others:
            return False
        if kind == NUMBERED:
            return max(map(int, words)) <= MOST_NUMBERED
        place = 0 if kind.startswith(FINGER) else -1
        return not {word[place] for word in words} <= AXES


def _patterns(name: Pattern) -> Iterator[tuple[str, str, Pattern]]:
    """Yield what is alike of the words in question, the word, and the name with the finger in its place."""
    message, signal = name
    for word in dict.fromkeys((*message, *signal)):
        kinds = [NUMBERED] if word.isdecimal() else dict.fromkeys([FINGER + word[1:], word[:-1] + FINGER])
        masked = [tuple(FINGER if each == word else each for each in part) for part in name]
        ways = {(masked[0], signal), (message, masked[1]), (masked[0], masked[1])} - {name}
        yield from ((kind, word, way) for kind in kinds for way in ways)
