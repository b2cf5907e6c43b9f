"""Several recordings of the same fingertip as one: each keeps its episodes, one after the other."""

import math
from collections.abc import Sequence

import numpy as np

from vegrip.errors import RecordingError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.report import LoadReport

PAUSE = 60.0  # [s] put between two recordings: long enough for a contact to recover


def joined(recordings: Sequence[Recording], name: str) -> Recording:
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
        begin, number = float(times[-1][-1]) + PAUSE, number + int(counted.max()) + 1
    columns = {key: np.concatenate([one.columns[key] for one in recordings]) for key in first.columns}
    sensors = {
        key: float(np.median([one.sensors[key] for one in recordings]))
        for key in first.sensors
        if all(key in one.sensors for one in recordings)
    }
    source: dict[str, str | int | float | bool] = {
        "files": ", ".join(str(one.source.get("file", one.name)) for one in recordings)
    }
    if not all(one.source.get("recovered", True) for one in recordings):
        source["recovered"] = False
    return Recording(
        name, np.concatenate(times), np.concatenate(episodes), columns, first.fingertip, sensors, source,
        report=_reports(recordings),
    )  # fmt: skip


def _reports(recordings: Sequence[Recording]) -> LoadReport:
    report = LoadReport()
    for one in recordings:
        report.rows_read += one.report.rows_read
        report.rows_kept += one.report.rows_kept
        for finding in one.report.findings:
            report.add(finding.kind, f"{one.name}: {finding.what}".rstrip(": "), finding.lines)
    return report
