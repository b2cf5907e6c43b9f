"""The table: of every pad, which effect, since when, and whether it is still there."""

import csv
import io
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

from vegrip.identification.fleet.row import FAILED, Found, Row

NONE = "none"
UNEXPLAINED = "unexplained"


@dataclass(frozen=True)
class Finding:
    """One effect of one pad."""

    hand: str
    pad: str
    effect: str  # its name, a set "a or b", "unexplained", "none", or "failed"
    # date of the first recording from which on it was always found; of the first one if it is found no more
    since: str
    until: str  # date of the last recording that shows it
    present: bool  # whether the latest recording of the pad that could be judged shows it
    shown: int  # in how many of the pad's recordings
    judged: int  # how many of them could be judged
    size: str = ""  # its parameters in the latest recording that shows it
    dated_by: str = "recording"  # or "file" where a date is only that of a file
    note: str = ""


def summarize_rows(examined: Sequence[tuple[Found, Row]]) -> list[Finding]:
    """Return the table, by hand and pad."""
    pads: dict[tuple[str, str], list[tuple[Found, Row]]] = defaultdict(list)
    for found, row in sorted(examined, key=lambda pair: (pair[0].date, pair[0].path)):
        pads[found.hand, found.pad].append((found, row))
    return [finding for pad in sorted(pads) for finding in _of_pad(pads[pad])]


def _of_pad(rows: list[tuple[Found, Row]]) -> list[Finding]:
    judged = [(found, row) for found, row in rows if row.verdict != FAILED]
    names = dict.fromkeys(name for _, row in judged for name in _shown(row))
    out = [_finding(name, judged) for name in names if name != NONE or len(names) == 1]
    for found, row in rows:
        if row.verdict == FAILED:
            out.append(
                Finding(found.hand, found.pad, FAILED, found.date, found.date, present=False, shown=0,
                        judged=len(judged), dated_by=found.dated_by, note=f"{found.path}: {row.note}")
            )  # fmt: skip
    return out


def _shown(row: Row) -> tuple[str, ...]:
    if row.verdict == "unexplained":
        return (*row.effects, UNEXPLAINED)
    return row.effects or (NONE,)


def _finding(name: str, judged: list[tuple[Found, Row]]) -> Finding:
    shows = [name in _shown(row) for _, row in judged]
    last = max(i for i, there in enumerate(shows) if there)
    first = shows.index(True)
    present = shows[-1]
    while present and first < last and not all(shows[first : last + 1]):
        first += 1 + shows[first + 1 :].index(True)
    found, row = judged[last]
    since = judged[first][0]
    by = "recording" if since.dated_by == found.dated_by == "recording" else "file"
    size = ", ".join(f"{symbol} {value:.3g}" for symbol, value in row.sizes.items()) if row.effects else ""
    return Finding(
        found.hand,
        found.pad,
        name,
        since.date,
        found.date,
        present,
        sum(shows),
        len(shows),
        size,
        by,
        "; ".join(text for text in (row.note, *row.doubts) if text),
    )


def write_csv(table: Sequence[Finding]) -> str:
    """Return the table as CSV."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [f.name for f in fields(Finding)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(one) for one in table)
    return stream.getvalue()
