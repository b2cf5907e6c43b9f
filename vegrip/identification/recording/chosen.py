"""Episodes by their numbers, as in ``2,5..7``: held back from a fit, or looked at alone."""

import numpy as np

from vegrip.errors import InputError, UsageError
from vegrip.identification.recording.data import Recording

MAX_EPISODES = 100_000  # episodes in one range


def parse_episodes(text: str, option: str) -> list[int]:
    """Return the numbers in ``text``.

    Raises:
        UsageError: it is no list of numbers and ranges; names ``option``.

    """
    found: set[int] = set()
    for part in (part.strip() for part in text.split(",") if part.strip()):
        first, dots, last = part.partition("..")
        try:
            low, high = int(first), int(last) if dots else int(first)
        except ValueError:
            low, high = 0, -1
        if not 0 <= high - low < MAX_EPISODES:
            raise UsageError(f"{option} has {part!r}; write episodes as in 2,5..7")
        found |= set(range(low, high + 1))
    return sorted(found)


def episodes_text(numbers: list[int]) -> str:
    """Return sorted ``numbers`` as they are written: ``2,5..7``."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ",".join(f"{run[0]}..{run[-1]}" if len(run) > 2 else ",".join(map(str, run)) for run in runs)


def select_episodes(recording: Recording, *, only: str = "", without: str = "") -> Recording:
    """Return the recording with the episodes ``only``, or ``without`` those; as it is where both are empty.

    Raises:
        UsageError: not a list of episodes.
        InputError: the recording has no such episode, or none is left.

    """
    chosen, dropped = parse_episodes(only, "--episodes"), parse_episodes(without, "--hold-back")
    there = dict.fromkeys(recording.episode.tolist())
    if missing := [number for number in (*chosen, *dropped) if number not in there]:
        raise InputError(
            f"{recording.name} has no episode {missing[0]}; its episodes are {episodes_text(sorted(there))}"
        )
    keep = np.isin(recording.episode, chosen) if chosen else np.ones(len(recording), dtype=bool)
    keep &= ~np.isin(recording.episode, dropped)
    if not keep.any():
        raise InputError(f"no episode of {recording.name} is left; it has {episodes_text(sorted(there))}")
    return recording if keep.all() else recording.select(keep)
