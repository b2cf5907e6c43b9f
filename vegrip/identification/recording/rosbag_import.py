"""From a rosbag to a recording: several topics on the time of one, then as from any table."""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.column_map import BagMap, ColumnMap, EpisodeMap, TableMap, TimeMap
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.extras import bag_library
from vegrip.identification.recording.import_csv import recording_of
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.rosbag_fields import BagField
from vegrip.identification.recording.rosbag_read import Samples, Series, in_order, read_series
from vegrip.identification.recording.table import Table
from vegrip.types import Floats


def import_rosbag(path: Path | str, chart: ColumnMap, *, radius: float = math.nan) -> Recording:
    """Read the bag ``path`` as ``chart`` says: a row per message of the topic ``[bag] time``.

    Values of other topics are the last ones at the row's time, at most ``[bag] largest_age`` old, else NaN;
    nothing is interpolated or filtered. The numbers in the report count the messages of a topic from 0.

    Args:
        path: rosbag 1 (``.bag``) or 2 (folder, ``.db3``, ``.mcap``).
        chart: its columns are ``/topic:field.of.the.message``.
        radius: of the fingertip [m]; overrides the map's.

    Raises:
        RecordingError: unreadable, or a topic, field, unit or age that does not fit; names topic and message.
        UsageError: the library rosbags is not installed.

    """
    bag_library("rosbags")  # first, so that no map is corrected in vain
    path, report = Path(path), LoadReport(place="message")
    fields = {name: BagField.parse(entry.column, name) for name, entry in chart.channels.items()}
    _check(path, chart)
    leader = _leader(path, fields, chart.bag)
    found = read_series(path, list(fields.values()), chart.bag, report)
    _note_clocks(found, chart.bag, report)
    report.rows_read = found[leader].messages
    rows = in_order(found[leader], report)
    if not len(rows.stamps):
        raise RecordingError(f"{path}: no usable message on {leader}; {report.summary()}")
    columns = dict(rows.columns)
    for topic, series in found.items():
        if topic != leader:
            columns |= _held(path, series, rows.stamps, chart.bag.largest_age, report)
    origin = int(rows.stamps[0])
    t = (rows.stamps - origin) / NS
    table = Table({chart.time.column: t, **columns}, {}, rows.index)
    return recording_of(path, table, chart, report, radius, origin)


def hold(
    stamps: NDArray[np.int64], values: Floats, at: NDArray[np.int64], largest_age: int
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the last of ``values`` at each time, and its age [ns]; NaN and -1 where there is none.

    Args:
        stamps: (n,) [ns] increasing.
        values: (n,) taken at ``stamps``.
        at: (m,) [ns] times to know the value at.
        largest_age: [ns] a value older than this is not used.

    """
    last = np.searchsorted(stamps, at, side="right") - 1
    age = np.where(last >= 0, at - stamps[np.maximum(last, 0)], -1)
    good = (age >= 0) & (age <= largest_age)
    return np.where(good, values[np.maximum(last, 0)], np.nan), np.where(good, age, -1)


def _check(path: Path, chart: ColumnMap) -> None:
    if not chart.channels:
        raise RecordingError(
            f"{path}: say which field is what, with --map-file or --map normal_force=/topic:wrench.force.z"
        )
    given = {"time": chart.time != TimeMap(), "episode": chart.episode != EpisodeMap()}
    for section, there in (given | {"table": chart.table != TableMap()}).items():
        if there:
            raise RecordingError(f"{path}: a bag has no [{section}]; its topics and time are said in [bag]")


def _leader(path: Path, fields: dict[str, BagField], bag: BagMap) -> str:
    topics = list(dict.fromkeys(each.topic for each in fields.values()))
    if bag.time and bag.time not in topics:
        raise RecordingError(f"{path}: [bag] time = {bag.time!r} must be one of {', '.join(topics)}")
    if len(topics) > 1 and not (bag.time and bag.largest_age):
        raise RecordingError(
            f"{path}: the topics {', '.join(topics)} need [bag] time = one of them, and largest_age [s]"
        )
    return bag.time or topics[0]


def _held(
    path: Path, series: Series, at: NDArray[np.int64], largest_age: float, report: LoadReport
) -> dict[str, Floats]:
    """Return the columns of ``series`` at the times ``at``; what is too old becomes NaN, and is counted."""
    samples: Samples = in_order(series, report)
    limit = round(largest_age * NS)
    ages = np.full(len(at), -1, dtype=np.int64)
    columns = {}
    for column, values in samples.columns.items():
        if len(samples.stamps):
            columns[column], ages = hold(samples.stamps, values, at, limit)
    used = ages >= 0
    if not np.any(used):
        raise RecordingError(
            f"{path}: {series.topic} has no value within {largest_age:g} s before any row; "
            "its clock may be another one: try [bag] stamp = 'receive'"
        )
    held, oldest = np.count_nonzero(used), ages.max() / NS
    report.add(Kind.NOTE, f"{series.topic}: known in {held} of {len(at)} rows, at most {oldest:.3g} s old")
    return columns


def _note_clocks(found: dict[str, Series], bag: BagMap, report: LoadReport) -> None:
    for topic, series in found.items():
        if series.received and bag.stamp == "header":
            report.add(Kind.NOTE, f"{topic} has no header: its time is that of reception")
