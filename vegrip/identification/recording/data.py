"""A recording in memory: what one fingertip measured, in SI units, and how well its sensors measure."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import CHANNELS, NOISES
from vegrip.identification.recording.report import LoadReport
from vegrip.messages import FingertipState
from vegrip.spelling import suggestion

Array = NDArray[np.float64]
Columns = dict[str, Array]


@dataclass(frozen=True, slots=True)
class Fingertip:
    """The fingertip that was recorded."""

    radius: float = parameter(math.nan, unit="m", low=1e-9, high=1.0, doc="radius; leave out when unknown")
    name: str = parameter("index", doc="finger: thumb, index, middle, ring or little")


@dataclass(frozen=True, eq=False)
class Recording:
    """Measurements of one fingertip.

    Attributes:
        name: of the recording, normally its folder's.
        t: (n,) [s], strictly increasing.
        episode: (n,) separate trials, the contact fully recovered in between.
        columns: channel -> (n,) float64, SI, NaN where missing; only the channels that were measured.
        fingertip: its radius [m] (NaN when unknown) and finger.
        sensors: standard deviation of the noise, by the names of
            :data:`vegrip.identification.recording.channels.NOISES`.
        source: where it came from, as written in ``[source]``.
        start: [ns] stamp of t = 0 on the clock of the recorder, 0 when there was none.
        report: what was found while it was read.

    """

    name: str
    t: Array
    episode: NDArray[np.int64]
    columns: Mapping[str, Array]
    fingertip: Fingertip = field(default_factory=Fingertip)
    sensors: Mapping[str, float] = field(default_factory=dict)
    source: Mapping[str, str | int | float | bool] = field(default_factory=dict)
    start: int = 0
    report: LoadReport = field(default_factory=LoadReport, repr=False)

    def __post_init__(self) -> None:
        if not self.columns or not set(self.columns) <= set(CHANNELS):
            raise RecordingError(
                f"{self.name}: the columns are {', '.join(self.columns) or 'none'}; "
                f"they must be some of {', '.join(CHANNELS)}"
            )
        if not set(self.sensors) <= set(NOISES):
            unknown = ", ".join(sorted(set(self.sensors) - set(NOISES)))
            raise RecordingError(
                f"{self.name}: unknown sensor {unknown}; {suggestion(unknown, NOISES, 'known are')}"
            )
        if {len(values) for values in (self.episode, *self.columns.values())} != {len(self.t)}:
            raise RecordingError(f"{self.name}: the columns differ in length")
        if not np.all(np.diff(self.t) > 0):
            raise RecordingError(f"{self.name}: the time does not increase with every row")

    def __len__(self) -> int:
        return len(self.t)

    @property
    def duration(self) -> float:
        """Time from the first to the last row [s]."""
        return float(self.t[-1] - self.t[0]) if len(self) else 0.0

    @property
    def stamps(self) -> NDArray[np.int64]:
        """(n,) [ns] after t = 0, rounded to whole nanoseconds."""
        return np.rint(self.t * NS).astype(np.int64)

    def states(self, finger: str = "", start: int = 0) -> Iterator[FingertipState]:
        """Yield the rows as messages: ``finger`` (default: the recorded one), t = 0 at ``start`` [ns]."""
        finger = finger or self.fingertip.name
        names = list(self.columns)
        rows = zip(*(self.columns[name].tolist() for name in names), strict=True)
        for seq, (stamp, row) in enumerate(zip(self.stamps.tolist(), rows, strict=True)):
            yield FingertipState(start + stamp, finger, seq, **dict(zip(names, row, strict=True)))

    def episodes(self) -> Iterator["Recording"]:
        """Yield every trial as a recording of its own, in order."""
        for episode in dict.fromkeys(self.episode.tolist()):
            yield self.select(self.episode == episode, f"{self.name} episode {episode}")

    def select(self, rows: NDArray[np.bool_], name: str = "") -> "Recording":
        """Return the recording of the chosen ``rows`` (n,) only."""
        columns = {channel: values[rows] for channel, values in self.columns.items()}
        return Recording(
            name or self.name,
            self.t[rows],
            self.episode[rows],
            columns,
            self.fingertip,
            self.sensors,
            self.source,
            self.start,
        )
