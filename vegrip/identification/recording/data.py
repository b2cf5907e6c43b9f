"""A recording in memory: what a fingertip measured, in SI units, and how well its sensors measure."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.displayed import Result
from vegrip.errors import InputError, KindError, RecordingError, UsageError, suggestion
from vegrip.identification.recording.channels import CHANNELS, NOISE_NAMES, RECORDED
from vegrip.identification.recording.report import LoadReport
from vegrip.messages import FingertipState
from vegrip.types import Floats

Columns = dict[str, Floats]
PAUSE_BETWEEN_S = 60.0  # [s] put between two recordings: long enough for a contact to recover
MAX_EPISODES = 100_000  # episodes in one range
MATERIAL = "material"  # key of [source] of a recording without a contact: relaxation, creep or
STRETCH = "stretch"  # tension against length


@dataclass(frozen=True, slots=True)
class Fingertip:
    """The fingertip that was recorded."""

    radius: float = parameter(math.nan, unit="m", low=1e-9, high=1.0, doc="radius; leave out when unknown")
    name: str = parameter("index", doc="finger: thumb, index, middle, ring or little")


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Result):
    """Measurements of one fingertip.

    Attributes:
        name: of the recording, normally its folder's.
        t: (n,) [s], strictly increasing.
        episode: (n,) separate trials, the contact fully recovered in between.
        columns: channel -> (n,) float64, SI, NaN where missing; only the channels that were measured.
        fingertip: its radius [m] (NaN when unknown) and finger.
        sensors: standard deviation of the noise, by the names of
            :data:`vegrip.identification.recording.channels.NOISE_NAMES`.
        source: where it came from, as written in ``[source]``.
        start: [ns] stamp of t = 0 on the clock of the recorder, 0 when there was none.
        report: what was found while it was read.

    """

    _display: ClassVar[str] = "recording"
    _calls: ClassVar[tuple[str, ...]] = ("episodes", "select", *Result._calls)

    name: str
    t: Floats
    episode: NDArray[np.int64]
    columns: Mapping[str, Floats]
    fingertip: Fingertip = field(default_factory=Fingertip)
    sensors: Mapping[str, float] = field(default_factory=dict)
    source: Mapping[str, str | int | float | bool] = field(default_factory=dict)
    start: int = 0
    report: LoadReport = field(default_factory=LoadReport)

    def __post_init__(self) -> None:
        given: Any = self.fingertip
        if not isinstance(given, Fingertip):
            raise KindError(f"{self.name}: fingertip is {given!r}; give vegrip.Fingertip(radius=8e-3), in m")
        arrays = {name: self._array(name, values) for name, values in self.columns.items()}
        object.__setattr__(self, "columns", arrays)
        object.__setattr__(self, "t", self._array("t", self.t))
        object.__setattr__(self, "episode", self._array("episode", self.episode, np.int64))
        if not self.columns or not set(self.columns) <= set(RECORDED):
            raise RecordingError(
                f"{self.name}: the columns are {', '.join(self.columns) or 'none'}; "
                f"they must be some of {', '.join(RECORDED)}"
            )
        if not set(self.sensors) <= set(NOISE_NAMES):
            unknown = ", ".join(sorted(set(self.sensors) - set(NOISE_NAMES)))
            raise RecordingError(
                f"{self.name}: unknown sensor {unknown}; {suggestion(unknown, NOISE_NAMES, 'known are')}"
            )
        if {len(values) for values in (self.episode, *self.columns.values())} != {len(self.t)}:
            raise RecordingError(f"{self.name}: the columns differ in length")
        if not np.all(np.diff(self.t) > 0):
            raise RecordingError(f"{self.name}: the time does not increase with every row")

    def _array(self, name: str, values: Any, kind: type = np.float64) -> Any:
        try:
            return np.asarray(values, dtype=kind)
        except (TypeError, ValueError) as error:
            raise RecordingError(f"{self.name}: {name} are no numbers ({error})") from None

    def __len__(self) -> int:
        return len(self.t)

    @property
    def duration(self) -> float:
        """Time from the first to the last row [s]."""
        return float(self.t[-1] - self.t[0]) if len(self) else 0.0

    @property
    def is_material(self) -> bool:
        """Whether it is of a specimen without a contact."""
        return MATERIAL in self.source

    @property
    def is_step(self) -> bool:
        """Whether it holds unit steps of a material, whose zeros are known and whose law is linear."""
        return self.source.get(MATERIAL, STRETCH) != STRETCH

    @property
    def stamps(self) -> NDArray[np.int64]:
        """(n,) [ns] after t = 0, rounded to whole nanoseconds."""
        return np.rint(self.t * NS).astype(np.int64)

    def states(self, finger: str = "", start: int = 0) -> Iterator[FingertipState]:
        """Yield the rows as messages: ``finger`` (default: the recorded one), t = 0 at ``start`` [ns]."""
        finger = finger or self.fingertip.name
        names = [name for name in self.columns if name in CHANNELS]
        rows = zip(*(self.columns[name].tolist() for name in names), strict=True)
        for seq, (stamp, row) in enumerate(zip(self.stamps.tolist(), rows, strict=True)):
            yield FingertipState(start + stamp, finger, seq, **dict(zip(names, row, strict=True)))

    def episodes(self) -> Iterator["Recording"]:
        """Yield the episodes one by one, each as a recording."""
        for episode in dict.fromkeys(self.episode.tolist()):
            yield self.select(self.episode == episode, f"{self.name} episode {episode}")

    def select(self, rows: NDArray[np.bool_], name: str = "") -> "Recording":
        """Return the recording of the chosen ``rows`` (n,) only."""
        columns = {channel: values[rows] for channel, values in self.columns.items()}
        t, episode = self.t[rows], self.episode[rows]
        return replace(
            self, name=name or self.name, t=t, episode=episode, columns=columns, report=LoadReport()
        )


def join_recordings(recordings: Sequence[Recording], name: str) -> Recording:
    """Return ``recordings`` as one; clocks begin anew in each, so they follow with a pause of a minute.

    Raises:
        RecordingError: their channels or fingertips differ; says which.

    """
    first = recordings[0]
    for other in recordings[1:]:
        if set(other.columns) != set(first.columns):
            lacking = set(first.columns) ^ set(other.columns)
            raise RecordingError(
                f"{first.name} and {other.name} do not go together: only one has {', '.join(sorted(lacking))}"
            )
        if (other.is_material, other.is_step) != (first.is_material, first.is_step):
            raise RecordingError(
                f"{first.name} and {other.name} do not go together: only one is of a step without a contact"
            )
        mine, its = first.fingertip.radius, other.fingertip.radius
        if mine != its and not (math.isnan(mine) and math.isnan(its)):
            raise RecordingError(
                f"{first.name} and {other.name} do not go together: radius {mine:g} m and {its:g} m"
            )
    times, episodes = [], []
    begin, number = 0.0, 0
    for one in recordings:
        times.append(one.t - one.t[0] + begin)
        _, counted = np.unique(one.episode, return_inverse=True)
        episodes.append(counted.astype(np.int64) + number)
        begin, number = float(times[-1][-1]) + PAUSE_BETWEEN_S, number + int(counted.max()) + 1
    columns = {key: np.concatenate([one.columns[key] for one in recordings]) for key in first.columns}
    sensors = {
        key: float(np.median([one.sensors[key] for one in recordings]))
        for key in first.sensors
        if all(key in one.sensors for one in recordings)
    }
    source: dict[str, str | int | float | bool] = {
        "files": ", ".join(str(one.source.get("file", one.name)) for one in recordings)
    }
    if first.is_material:
        source[MATERIAL] = ", ".join(dict.fromkeys(str(one.source[MATERIAL]) for one in recordings))
    if not all(one.source.get("recovered", True) for one in recordings):
        source["recovered"] = False
    return Recording(
        name, np.concatenate(times), np.concatenate(episodes), columns, first.fingertip, sensors, source,
        report=_reports(recordings),
    )  # fmt: skip


def _reports(recordings: Sequence[Recording]) -> LoadReport:
    report = LoadReport()
    for one in recordings:
        report.include(one.name, one.report)
    return report


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
