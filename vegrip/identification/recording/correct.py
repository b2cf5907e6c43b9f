"""Corrections of one trial: zeros, series compliance, first touch, and the noise of a quiet stretch."""

import numpy as np

from vegrip.errors import RecordingError
from vegrip.identification.recording.column_map import ColumnMap
from vegrip.identification.recording.data import Array, Columns
from vegrip.identification.recording.report import Kind, LoadReport


def correct_trial(
    t: Array, columns: Columns, force_noise: float, chart: ColumnMap, report: LoadReport
) -> None:
    """Correct the ``columns`` of one trial in place: first the force, because the others need its zero.

    A cantilever of stiffness ``k`` bends by ``N / k`` under the force ``N``, so that of its travel only
    ``travel - N / k`` is indentation: ``compliance = 1 / k``.
    """
    for name in sorted(columns, key=lambda name: name != "normal_force"):
        entry, values = chart.channels[name], columns[name]
        if entry.compliance:
            values -= entry.compliance * _force(columns, name)
        if entry.zero == "first":
            values -= _first_known(values)
        elif entry.zero == "baseline":
            values -= _baseline_mean(t, values, name, chart.baseline.duration)
        elif entry.zero == "contact":
            threshold = chart.contact.threshold or 5.0 * force_noise
            values -= _value_at_touch(values, columns, name, threshold, report)


def first_touch(force: Array, threshold: float) -> int | None:
    """Return the row of first contact: the last rise through ``threshold`` [N] before the peak force.

    Seen from the peak backwards, so that spikes before contact (an oscillating lever, an impact that
    bounces off) do not count. None when the force never reaches the threshold.
    """
    if np.all(np.isnan(force)):
        return None
    peak = int(np.nanargmax(force))
    if not force[peak] >= threshold:
        return None
    below = np.flatnonzero(force[:peak] < threshold)
    return int(below[-1]) + 1 if len(below) else 0


def baseline_noise(values: Array) -> float:
    """Return the standard deviation of white noise in ``values``, blind to slow drift; 0 if not to be had.

    From first differences, ``std(x[i+1] - x[i]) / sqrt(2)``, with the median absolute deviation (1.4826 for
    a Gaussian) so that single spikes do not count.
    """
    differences = np.diff(values[~np.isnan(values)])
    if len(differences) < 10:
        return 0.0
    spread = np.median(np.abs(differences - np.median(differences)))
    return float(1.4826 * spread / np.sqrt(2.0))


def _first_known(values: Array) -> float:
    """Return the first value that is not missing, 0 when all are."""
    known = values[~np.isnan(values)]
    return float(known[0]) if len(known) else 0.0


def _baseline_mean(t: Array, values: Array, name: str, duration: float) -> float:
    quiet = values[t < t[0] + duration]
    if not len(quiet) or np.all(np.isnan(quiet)):
        raise RecordingError(f"{name}: zero = 'baseline' needs a [baseline] duration longer than a sample")
    return float(np.nanmean(quiet))


def _value_at_touch(
    values: Array, columns: Columns, name: str, threshold: float, report: LoadReport
) -> float:
    if not threshold:
        raise RecordingError(f"{name}: zero = 'contact' needs a [contact] threshold or a [baseline] duration")
    touch = first_touch(_force(columns, name), threshold)
    if touch is None:
        report.add(Kind.NOTE, f"no contact found above {threshold:g} N; {name} keeps its zero")
        return 0.0
    return float(values[touch])


def _force(columns: Columns, name: str) -> Array:
    if "normal_force" not in columns:
        raise RecordingError(f"{name}: its correction needs normal_force; map a column to it")
    return columns["normal_force"]
