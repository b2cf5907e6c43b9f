"""Times as loggers write them: as differences, too coarse, or with a clock that was set while it ran."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.types import Floats

LEAST_ROWS: Final = 20  # that show what the times are
STANDING: Final = 0.3  # of the rows, from which times that do not grow are no accident (origin: rule)
REVERSED: Final = 0.9  # of the steps go back where the rows stand in reverse order (origin: rule)
REGULAR: Final = 0.9  # of the stamps stand for as many rows as the others, within a fifth or one
LEAST_RUN: Final = 20  # rows between two times at which a clock was set
MOST_SETTINGS: Final = 10  # of a clock
SET_BACK_S: Final = 0.05  # [s] by which frames of two channels may be out of order in a log


def mended(
    t: Floats,
    report: LoadReport,
    *,
    spread: bool = False,
    is_in_order: bool = False,
    senders: NDArray[np.int64] | None = None,
) -> Floats:
    """Return ``t`` [s] such that it grows, where there is one way to read it; what was done is reported.

    Args:
        t: (n,) as it stands in the file.
        report: is added to.
        spread: rows of one time stamp get times of their own, also where they are of uneven number.
        is_in_order: the rows stand as they came, so that a step back is a clock that was set.
        senders: (n,) of the rows: rows of one time stamp that are of several senders came together.

    """
    known = np.isfinite(t)
    if np.count_nonzero(known) < LEAST_ROWS or not np.any(np.diff(t[known]) <= 0.0):
        return t
    found, result = t[known], t.copy()
    if doubt := _no_time(found):
        report.add(Kind.AMBIGUOUS, doubt)
        return t
    if is_differences(found):
        report.add(Kind.NOTE, "the times are differences from row to row, and were summed")
        if not known.all() or _has_unknown_rows(report):
            report.add(Kind.SUSPECT, "what follows rows that could not be read is too early by their times")
        result[known] = np.cumsum(found) - found[0]
        return result
    if is_in_order:
        found = _joined(found, report)
    if spread or senders is None or not _came_together(found, senders[known]):
        found = _spread(found, report, asked=spread)
    result[known] = found
    return result


def _came_together(t: Floats, senders: NDArray[np.int64]) -> bool:
    own = np.unique(np.stack([t, senders]), axis=1).shape[1]
    return bool(own > REGULAR * len(t))


def _no_time(t: Floats) -> str:
    """Return why ``t`` cannot be the time of rows one after the other, "" where it can."""
    if not np.ptp(t) > 0.0:
        return (
            f"all rows have the time {t[0]:g} s; give the column, or have the logger write times, that grow"
        )
    if np.mean(np.diff(t) < 0.0) > REVERSED:
        return (
            "the time falls from row to row, so the last row stands first; turn the rows round, as tac does"
        )
    return ""


def is_differences(t: Floats) -> bool:
    """Whether ``t`` are the times since the row before: they do not grow, and have no trend."""
    steps = np.diff(t)
    back, still = float(np.mean(steps < 0.0)), float(np.mean(steps == 0.0))
    if t.min() < 0.0 or back + still < STANDING:
        return False
    if back == 0.0:
        return bool(t[1] > t[0] == 0.0 and np.all(t[1:] == t[1]))
    halves = np.array_split(t, 2)
    return (
        abs(float(np.median(halves[1]) - np.median(halves[0]))) <= STANDING * float(np.ptp(t)) or back > still
    )


def _has_unknown_rows(report: LoadReport) -> bool:
    """Whether rows are left out of which not even the time is known."""
    return any(report.count(kind) for kind in (Kind.FIELDS, Kind.CUT, Kind.DECODE))


def _joined(t: Floats, report: LoadReport) -> Floats:
    """Return ``t`` with each stretch after a clock was set back put behind the one before."""
    back = np.flatnonzero(np.diff(t) < -SET_BACK_S) + 1
    back = back[t[back] <= t[np.maximum(back - 2, 0)]]  # else it is the row before that has a wild time
    edges = np.concatenate([[0], back, [len(t)]])
    if not back.size or back.size > MOST_SETTINGS or np.diff(edges).min() < LEAST_RUN:
        return t
    steps, mended_t = np.diff(t), t.copy()
    step = float(np.median(steps[steps > 0.0]))
    for at in back.tolist():
        mended_t[at:] += mended_t[at - 1] + step - mended_t[at]
    report.add(
        Kind.NOTE,
        f"the clock was set back {back.size} x while it ran; what came after follows what came before",
    )
    return mended_t


def _spread(t: Floats, report: LoadReport, *, asked: bool) -> Floats:
    """Return ``t`` with the rows of each stamp spread evenly until the next."""
    steps = np.diff(t)
    starts = np.concatenate([[0], np.flatnonzero(steps != 0.0) + 1])
    counts = np.diff(np.concatenate([starts, [len(t)]]))
    usual = int(np.median(counts))
    if np.any(steps < 0.0) or len(starts) < 3 or (counts.max() == 1):
        return t
    inner = counts[1:-1]
    is_regular = usual > 1 and np.mean(np.abs(inner - usual) <= max(1.0, 0.2 * usual)) >= REGULAR
    if not (is_regular or asked):
        return t
    stamps = t[starts]
    spans = np.diff(stamps)
    spans = np.append(spans, np.median(spans))
    period = np.minimum(spans / np.maximum(counts, 1), np.median(spans) / max(usual, 1))
    if not is_regular:
        period = spans / counts
    within = np.arange(len(t)) - np.repeat(starts, counts)
    late = np.zeros(len(starts))
    late[0] = spans[0] - counts[0] * period[0]  # the first stamp is seldom whole
    if _has_unknown_rows(report):
        report.add(Kind.SUSPECT, "rows beside those that could not be read are off by up to a time stamp")
    said = f"{len(t)} rows have {len(starts)} time stamps, and were spread evenly between them"
    report.add(Kind.NOTE, said)
    spread: Floats = np.repeat(stamps + late, counts) + within * np.repeat(period, counts)
    return spread
