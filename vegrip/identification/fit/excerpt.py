"""What is fitted of a recording of an hour: pieces of it, drawn evenly over its whole length.

Time and memory of a fit grow with the rows, the information in a recording with their root: past some
hundred thousand rows it is the forms of the laws that limit a verdict, and no more the noise. A piece is an
episode, or where an episode is long about a minute of it, cut in its longest pauses in the air. Of
neighbouring pieces one is drawn, so that a drift, a wear or a change shows as in the whole.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.fit.noise import in_air
from vegrip.identification.recording import Recording
from vegrip.identification.recording.checks import stretches_of

MOST_ROWS = 400_000
PIECE_S = 60.0  # [s] of a long episode
LEAST_PAUSE_S = 1.0  # [s] in the air, for a cut
EXCERPT = "excerpt"  # in the source of a recording


def excerpt(recording: Recording) -> Recording:
    """Return ``recording``, or where it has more than ``MOST_ROWS`` a share of its pieces that has fewer."""
    if len(recording) <= MOST_ROWS:
        return recording
    number = _pieces(recording)
    count = int(number[-1]) + 1
    of = -(-len(recording) // MOST_ROWS)  # neighbouring pieces of which one is drawn
    if count < 2 * of:
        return recording
    drawn = np.random.default_rng(0).integers(of, size=-(-count // of)) + of * np.arange(-(-count // of))
    chosen = np.isin(number, drawn)
    pieces, rows = np.unique(number[chosen]).size, np.count_nonzero(chosen)
    note = f"of this recording {pieces} of {count} pieces are used, {rows} of {len(recording)} rows"
    cut = np.unique(recording.episode).size < count
    part = replace(recording, episode=number) if cut else recording
    return replace(part.select(chosen), source={**recording.source, EXCERPT: note})


def _pieces(recording: Recording) -> NDArray[np.int64]:
    """Return the number of the piece (n,) that each row belongs to."""
    t, starts = recording.t, np.zeros(len(recording), dtype=np.int64)
    pauses = _pauses(recording)
    for rows in stretches_of(recording.episode):
        starts[rows.start] = 1
        since = rows.start
        inside = [(a, b) for a, b in pauses if rows.start < a and b < rows.stop]
        while t[rows.stop - 1] - t[since] > 1.5 * PIECE_S:
            near = [(a, b) for a, b in inside if 0.5 * PIECE_S < t[a] - t[since] < 1.5 * PIECE_S]
            later = [(a, b) for a, b in inside if t[a] - t[since] >= 1.5 * PIECE_S]
            if not near and not later:
                break
            a, b = max(near, key=lambda ends: t[ends[1]] - t[ends[0]]) if near else later[0]
            since = (a + b) // 2
            starts[since] = 1
    number: NDArray[np.int64] = np.cumsum(starts) - 1
    return number


def _pauses(recording: Recording) -> list[tuple[int, int]]:
    """Return first and last row of each long stay in the air."""
    away = in_air(recording).astype(np.int64)
    edges = np.diff(np.r_[0, away, 0])
    ends = zip(np.flatnonzero(edges == 1).tolist(), (np.flatnonzero(edges == -1) - 1).tolist(), strict=True)
    return [(a, b) for a, b in ends if recording.t[b] - recording.t[a] >= LEAST_PAUSE_S]
