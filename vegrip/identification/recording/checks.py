"""What a table of measurements must satisfy to be a recording, and what makes its units doubtful."""

from bisect import bisect_left
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.table import report_if

SLOWEST: Final = 60.0
"""[s] A fingertip sampled more rarely than this has its time in another unit."""
FASTEST: Final = 1e-6
"""[s] And so has one sampled more often."""

Array = NDArray[np.float64]
Lines = NDArray[np.int64]


def usable_rows(t: Array, lines: Lines, report: LoadReport, what: str = "") -> NDArray[np.bool_]:
    """Return which rows (of ``what``, when there are several sources) have a stamp later than the one before.

    Kept is the longest strictly increasing run through the file: one wild stamp costs one row, and a clock
    set back costs the shorter part, never everything after it.
    """
    stamped = ~np.isnan(t)
    report_if(report, Kind.NO_TIME, what, lines[~stamped])
    keep = np.zeros(len(t), dtype=bool)
    keep[np.flatnonzero(stamped)[longest_increasing(t[stamped])]] = True
    left_out = stamped & ~keep
    twice = left_out & np.isin(t, t[keep])
    report_if(report, Kind.DUPLICATE, what, lines[twice])
    report_if(report, Kind.BACKWARDS, what, lines[left_out & ~twice])
    return keep


def longest_increasing(values: Array) -> NDArray[np.int64]:
    """Return the indices of the longest strictly increasing subsequence (patience sorting, n log n).

    It is built from the end backwards, so that of several ones, and of equal values, the earlier rows stand.
    """
    if np.all(np.diff(values) > 0):
        return np.arange(len(values), dtype=np.int64)
    tails: list[float] = []  # largest first value, with its sign turned, of a run of each length
    starts: list[int] = []  # and where it stands
    after = np.empty(len(values), dtype=np.int64)
    for i in range(len(values) - 1, -1, -1):
        length = bisect_left(tails, -values[i])
        after[i] = starts[length - 1] if length else -1
        tails[length : length + 1] = [-values[i]]  # replaces, or appends at the end
        starts[length : length + 1] = [i]
    chain = [starts[-1]]
    while after[chain[-1]] >= 0:
        chain.append(int(after[chain[-1]]))
    return np.array(chain, dtype=np.int64)


def report_doubts(
    t: Array, columns: dict[str, Array], radius: float, lines: Lines, report: LoadReport
) -> None:
    """Report missing values and values that suggest a wrong unit; nothing is left out for them."""
    for name, values in columns.items():
        report_if(report, Kind.MISSING, name, lines[np.isnan(values)])
        quantity = CHANNELS[name]
        outside = (values < quantity.low) | (values > quantity.high)
        bounds = f"{name} outside {quantity.low:g} .. {quantity.high:g} {quantity.unit}"
        report_if(report, Kind.IMPLAUSIBLE, bounds, lines[outside])
    for name in ("displacement", "contact_radius"):
        if name in columns and radius > 0:
            larger = f"{name} larger than the fingertip's radius of {radius:g} m"
            report_if(report, Kind.IMPLAUSIBLE, larger, lines[columns[name] > radius])
    step = float(np.median(np.diff(t))) if len(t) > 1 else 1.0
    if not FASTEST <= step <= SLOWEST:
        report.add(Kind.IMPLAUSIBLE, f"t advances by {step:g} s a row", [int(lines[0])])
