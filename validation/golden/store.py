"""The file of golden answers, and what differs from it.

``golden.json`` has for each case a digest of each kind of answer and a few plain numbers. Beside it, in
``build/golden`` and not committed, ``--update`` keeps what the digests are of, so that a later difference can
be shown line by line on the same machine.
"""

import gzip
import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

FILE = Path(__file__).parents[1] / "golden.json"
TRACES = Path("build") / "golden"
RULES = {
    "commands": "of each ForceCommand as it was sent: time [us], finger, counter, force, change, reason, end",
    "reports": "of each contact, slip margin, health and learned parameter as it was sent",
    "conditions": "of the input of all fingers, whenever one changes, with the time",
    "counts": "what was refused, lost, clipped, answered; by name",
    "bytes": "of all that was sent by each identifier or topic, with the times; to the bit",
    "of a library": "where a solver of a library answers (contacts), the last digits are those of the "
    "processor's linear algebra: conditions and counts are digested, plain numbers agree to 1e-5",
    "rounding": "real numbers to nine significant digits before they are digested, counts and flags as they "
    "are; 'bytes' to the bit, so it alone may differ on a machine with another libm",
    "numbers": "to judge a difference by eye, and for --tolerance: how many commands, reports and changes of "
    "condition; mean force [N] of each eighth of the commands, the largest force [N], the last friction",
}

OF_LIBRARY = 1e-5
"""By how much plain numbers may differ between two processors; they have six digits."""

Lines = Mapping[str, list[str]]


@dataclass(frozen=True)
class Answered:
    """What came of one case."""

    name: str
    lines: Lines  # by kind of answer
    numbers: Mapping[str, Any]
    of_library: bool = False  # some of it comes from a solver whose last digits the processor decides

    @property
    def entry(self) -> dict[str, Any]:
        """Return what the file has of it."""
        kinds = ("conditions", "counts") if self.of_library else self.lines
        return {kind: digest(self.lines[kind]) for kind in kinds} | {"numbers": dict(self.numbers)}


def digest(lines: Iterable[str]) -> str:
    """Return a digest of lines."""
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


def read() -> dict[str, Any]:
    """Return the entries of the file by name; none where there is no file."""
    if not FILE.exists():
        return {}
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))["cases"]
    return found


def write(entries: Mapping[str, Any]) -> None:
    """Write the file, one line a case."""
    rules = json.dumps(RULES, indent=1)
    cases = ",\n".join(f"{json.dumps(name)}: {json.dumps(entries[name])}" for name in sorted(entries))
    FILE.write_text(f'{{"about": {rules},\n"cases": {{\n{cases}\n}}}}\n', encoding="utf-8")


def _trace(name: str) -> Path:
    safe = "".join(letter if letter.isalnum() else "-" for letter in name)
    return TRACES / f"{safe}.json.gz"


def keep(answered: Answered) -> None:
    """Keep what the digests are of, on this machine."""
    TRACES.mkdir(parents=True, exist_ok=True)
    with gzip.open(_trace(answered.name), "wt", encoding="utf-8", compresslevel=1) as file:
        json.dump(answered.lines, file)


def differences(answered: Answered, expected: Mapping[str, Any] | None, tolerance: float | None) -> list[str]:
    """Return in sentences what is other than expected; empty: nothing.

    With a ``tolerance`` only the plain numbers are compared, real ones by their relative difference.
    """
    if expected is None:
        return ["it is not in the file; --update adds it"]
    entry = answered.entry
    if tolerance is not None:
        return list(_far(entry["numbers"], expected["numbers"], tolerance))
    kinds = [kind for kind in entry if kind != "numbers" and entry[kind] != expected.get(kind)]
    kept = _kept(answered.name)
    found = []
    for kind in kinds:
        before = kept.get(kind)
        if before is not None and digest(before) == expected.get(kind):
            found.append(f"{kind}: {first_difference(before, answered.lines[kind])}")
        else:
            found.append(
                f"{kind}: {expected.get(kind)} was expected, {entry[kind]} came (no trace of it here)"
            )
    share = OF_LIBRARY if answered.of_library else 0.0
    if (kinds or share) and (moved := list(_far(entry["numbers"], expected["numbers"], share))):
        found.append("numbers: " + "; ".join(moved))
    return found


def first_difference(before: list[str], now: list[str]) -> str:
    """Return in words where two lists of lines part."""
    differing = sum(a != b for a, b in zip_longest(before, now))
    number = next(i for i, (a, b) in enumerate(zip_longest(before, now)) if a != b)
    a, b = (lines[number] if number < len(lines) else "nothing" for lines in (before, now))
    return f"{differing} of {len(before)} lines differ, first number {number}: {a!r} was, {b!r} is"


def _kept(name: str) -> dict[str, list[str]]:
    try:
        with gzip.open(_trace(name), "rt", encoding="utf-8") as file:
            found: dict[str, list[str]] = json.load(file)
            return found
    except (OSError, ValueError):
        return {}


def _far(now: Mapping[str, Any], before: Mapping[str, Any], tolerance: float) -> Iterator[str]:
    for name in sorted(now.keys() | before.keys()):
        pairs = list(zip_longest(_flat(before.get(name)), _flat(now.get(name))))
        if any(not _is_near(a, b, tolerance) for a, b in pairs):
            yield f"{name} was {before.get(name)}, is {now.get(name)}"


def _flat(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _is_near(a: Any, b: Any, tolerance: float) -> bool:
    if isinstance(a, int | float) and isinstance(b, int | float):
        return (math.isnan(a) and math.isnan(b)) or a == b or abs(a - b) <= tolerance * max(abs(a), abs(b))
    return bool(a == b)
