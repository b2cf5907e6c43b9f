"""A protocol as instants: what is imposed at each, and the motion of the counter-surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.simulate.protocol import Protocol, Segment

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Piece:
    """A segment on the timeline: rows ``begin`` to ``end``, and the level it starts from if that is known."""

    segment: Segment
    begin: int
    end: int
    by_force: bool
    start: float | None  # [m] or [N]; None where the axis changes from depth to force or back
    stop: float | None  # None: as it started


@dataclass(frozen=True, eq=False)
class Timeline:
    """Instants of a protocol.

    Attributes:
        t: (n,) [s], the pauses left out of the rows but not of the time.
        episode: (n,) number.
        pull: (n, 3) velocity of the counter-surface x, y [m/s] and its spin [rad/s].
        pieces: the segments, in order.

    """

    t: Floats
    episode: NDArray[np.int64]
    pull: Floats
    pieces: tuple[Piece, ...]

    def imposed(self, depth: Floats, force: Floats) -> tuple[Floats, Floats]:
        """Return what is imposed, depth (n,) [m] and force (n,) [N], NaN where the other one is.

        ``depth`` and ``force`` are what is known of both so far; where the axis goes over from one to the
        other, a segment starts from there.
        """
        out = np.full((2, self.t.size), np.nan)
        for piece in self.pieces:
            known = force if piece.by_force else depth
            start = piece.start if piece.start is not None else float(known[piece.begin - 1])
            stop = start if piece.stop is None else piece.stop
            part = np.arange(1, piece.end - piece.begin + 1) / (piece.end - piece.begin)
            wave = np.sin(2.0 * np.pi * piece.segment.frequency * part * piece.segment.duration)
            path = start + part * (stop - start) + piece.segment.amplitude * wave
            out[int(piece.by_force), piece.begin : piece.end] = path
        return out[0], out[1]

    @property
    def changes(self) -> int:
        """How often the axis goes over between depth and force within one episode, at most."""
        count = np.zeros(int(self.episode.max()) + 1, dtype=int)
        for piece in self.pieces:
            count[self.episode[piece.begin]] += piece.start is None
        return int(count.max())


def timeline(protocol: Protocol, step: float) -> Timeline:
    """Return the instants of ``protocol``, ``step`` [s] apart; every segment has at least one."""
    t, episode, pull, pieces = [], [], [], []
    begin, time = 0, 0.0
    for number, segments in enumerate(protocol.episodes):
        by_force, level = False, 0.0
        ticks = 0
        for segment in segments:
            axis = by_force if segment.depth is None and segment.force is None else segment.force is not None
            stop = segment.force if axis else segment.depth
            count = max(1, round(segment.duration / step))
            start = level if axis == by_force else None if ticks else 0.0
            pieces.append(Piece(segment, begin, begin + count, axis, start, stop))
            by_force, level = axis, stop if stop is not None else level
            t.append(time + step * np.arange(ticks + 1, ticks + count + 1))
            pull.append(np.tile([segment.pull_x, segment.pull_y, segment.spin], (count, 1)))
            episode.append(np.full(count, number, dtype=np.int64))
            begin, ticks = begin + count, ticks + count
        time += ticks * step + protocol.pause
    return Timeline(np.concatenate(t), np.concatenate(episode), np.concatenate(pull), tuple(pieces))
