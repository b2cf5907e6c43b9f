"""From any table of numbers to a recording: rename, convert to SI, zero, correct, check."""

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.errors import RecordingError, listed, suggestion
from vegrip.identification.recording.channels import (
    IMPORTED,
    RECORDED,
    STEP_QUANTITIES,
    STRETCHES,
    noise_name,
)
from vegrip.identification.recording.checks import (
    MIN_SAMPLE_PERIOD_S,
    report_doubts,
    stretches_of,
    usable_rows,
)
from vegrip.identification.recording.column_map import (
    ColumnMap,
    header_units,
    own_columns,
    row_units,
    step_columns,
    suspect_units,
    unread_force,
)
from vegrip.identification.recording.data import MATERIAL, STRETCH, Columns, Recording, join_recordings
from vegrip.identification.recording.mended_times import mended
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.table import (
    SECTION_COLUMN,
    Layout,
    Progress,
    Table,
    read_header,
    read_table,
)
from vegrip.identification.recording.table_form import find_layout
from vegrip.identification.recording.units import to_si
from vegrip.types import Floats

LOST_TRIALS = 0.1  # of the rows left out, from which it is looked for trials that lie over each other
REST_ROWS = 20  # at the start of a trial, before its press
LEAST_TOUCH_ROWS = 10  # at rest, for the noise above which the force has risen
LEAST_NOISE_ROWS = 300  # at rest, which give the noise to 8 %; from fewer it is left to the fit
LEAST_STEP_ROWS = 10
STEP_STRAIN = 1e-5  # displacement [m] of the specimen at a step; all is linear in it
PA_PER_MPA = 1e6
SPECIMEN = (("strain", "displacement", 1e-3), ("stress", "normal_force", 1.0 / PA_PER_MPA))
"""What is measured of one that is stretched, as which channel, and its length [m] and section [m^2]."""
EARLIEST, EARLY_ROWS = 1e-3, 12  # of the time of a creep's first row, from which it is continued backwards
STEPS_HELD = {"modulus": "relaxation", "compliance": "creep"}
LATE_STEPS, LATE_GROWTH = 100.0, 3.0
"""A step is sampled at even or at geometric times; what grows quicker began elsewhere (origin: rule)."""
TOUCH_SHARE = 0.01  # of the peak force


def correct_trial(
    t: Floats, columns: Columns, force_noise: float, chart: ColumnMap, report: LoadReport
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
            known = values[~np.isnan(values)]
            values -= known[0] if len(known) else 0.0
        elif entry.zero == "baseline":
            values -= _baseline_mean(t, values, name, chart)
        elif entry.zero == "contact":
            threshold = chart.contact.threshold or 5.0 * force_noise
            if not threshold:
                needed = _said(chart, "--baseline SECONDS", "a [contact] threshold or a [baseline] duration")
                raise RecordingError(
                    f"{name}: to find the contact the noise of the force before it is needed; give {needed}, "
                    "the time without contact at the start of every trial"
                )
            values -= _value_at_touch(values, columns, name, threshold, report)


def first_touch(force: Floats, threshold: float) -> int | None:
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


def baseline_noise(stretches: Iterable[Floats], least: int) -> float:
    """Return the standard deviation of the white noise in all ``stretches``, blind to slow drift.

    From first differences, ``std(x[i+1] - x[i]) / sqrt(2)``, with the median absolute deviation (1.4826 for
    a Gaussian) so that single spikes do not count; 0 where they hold fewer than ``least`` rows.
    """
    known = [values[~np.isnan(values)] for values in stretches]
    if sum(len(values) for values in known) < least:
        return 0.0
    differences = np.concatenate([np.diff(values) for values in known])
    spread = np.median(np.abs(differences - np.median(differences)))
    return float(1.4826 * spread / np.sqrt(2.0))


def _said(chart: ColumnMap, option: str, key: str) -> str:
    """Return the remedy as the user asked: by options, or in the map that was written."""
    return key if chart.name else option


def _baseline_mean(t: Floats, values: Floats, name: str, chart: ColumnMap) -> float:
    quiet = values[t < t[0] + chart.baseline.duration]
    if not len(quiet) or np.all(np.isnan(quiet)):
        needed = _said(chart, "--baseline SECONDS", "a [baseline] duration")
        raise RecordingError(
            f"{name}: its zero is the mean before the contact; give {needed}, longer than a sample"
        )
    return float(np.nanmean(quiet))


def _value_at_touch(
    values: Floats, columns: Columns, name: str, threshold: float, report: LoadReport
) -> float:
    touch = first_touch(_force(columns, name), threshold)
    if touch is None:
        report.add(Kind.NOTE, f"no contact found above {threshold:g} N; {name} keeps its zero")
        return 0.0
    return float(values[touch])


def _force(columns: Columns, name: str) -> Floats:
    if "normal_force" not in columns:
        raise RecordingError(f"{name}: its correction needs normal_force; map a column to it")
    return columns["normal_force"]


def import_csv(
    path: Path | str,
    column_map: ColumnMap | None = None,
    *,
    radius: float = math.nan,
    is_step: bool = False,
    progress: Progress = lambda _: None,
) -> Recording:
    """Read the table ``path`` as ``column_map`` says; nothing is resampled or filtered.

    Args:
        path: CSV or similar, plain or ``.gz``.
        column_map: where each channel comes from; a column that it does not name is taken as what it is
            called, in the unit behind its name, as ``normal_force_mN``, else in SI.
        radius: of the fingertip or probe [m]; overrides the map's.
        is_step: the table holds a unit step: a modulus or a compliance against the time since.
        progress: called with the number of rows read so far, now and then.

    Raises:
        RecordingError: unreadable, a column is missing, a unit does not fit; names file and line.

    """
    path, report = Path(path), LoadReport()
    chart = column_map or ColumnMap()
    layout, unusual = find_layout(path, chart.table)
    if unusual:
        report.add(Kind.NOTE, f"found by itself: {unusual}")
    header = read_header(path, layout)
    mapped, chart = chart, own_columns(step_columns(chart, header) if is_step else chart, header)
    if taken := chart.channels.keys() - mapped.channels.keys() if mapped.channels else ():
        report.add(Kind.NOTE, f"taken by their names: {', '.join(sorted(taken))}")
    _check_mapped(path, chart, header)
    if is_step and not STEP_QUANTITIES.keys() & chart.channels.keys():
        raise RecordingError(
            f"{path}: a step has a modulus or a compliance; say which column it is: --map modulus=COLUMN"
        )
    chart, below = row_units(chart, header, _below(layout), path)
    if below:
        report.add(Kind.NOTE, f"units taken from the line below the header: {', '.join(below)}")
    chart, units = header_units(chart)
    for sentence in suspect_units(chart):
        report.add(Kind.SUSPECT, sentence)
    if units:
        report.add(Kind.NOTE, f"units taken from the names of the columns: {', '.join(units)}")
    numbers = [chart.time.column, *(entry.column for entry in chart.channels.values())]
    words = [chart.episode.column] if chart.episode.column else []
    used = {"", *numbers, *words, SECTION_COLUMN if layout.section else ""}
    if unused := [name for name in header if name not in used]:
        report.add(Kind.COLUMN, listed(unused))
    if sentence := unread_force(chart, unused):
        report.add(Kind.SUSPECT, sentence)
    table = read_table(path, list(dict.fromkeys(numbers)), words, layout, report, progress)
    return recording_of(path, table, chart, report, radius)


def _below(layout: Layout) -> tuple[str, ...]:
    """Return the line of units, with a cell for the number of the section where there are several."""
    return ("", *layout.units) if layout.section else layout.units


def recording_of(
    path: Path, table: Table, chart: ColumnMap, report: LoadReport, radius: float, origin: int = 0
) -> Recording:
    """Return the recording that ``chart`` makes of ``table``; ``path`` names it in complaints.

    Args:
        path: where the table came from.
        table: has the columns that ``chart`` maps.
        chart: what each column is.
        report: is added to.
        radius: of the fingertip [m], NaN takes that of ``chart``.
        origin: [ns] stamp of time 0 of the table, 0 when it has none.

    """
    trial = _trials(table, chart)
    if STEP_QUANTITIES.keys() & chart.channels.keys():
        return steps_of(path, table, trial, chart, report)
    is_stretch = bool(STRETCHES.keys() & chart.channels.keys())
    if is_stretch:
        chart = _of_specimen(path, chart)
    t = _seconds(path, table, trial, chart, report)
    keep = usable_rows(t, table.lines, report)
    report.rows_kept = int(np.count_nonzero(keep))
    if not report.rows_kept:
        raise RecordingError(f"{path}: no usable row; {report.summary()}")
    if not chart.episode.column and len(keep) > report.rows_kept / (1.0 - LOST_TRIALS):
        _suspect_trials(t, report)
    start = origin + round(float(t[keep][0]) * NS) if origin else 0
    t, trial, lines = t[keep] - t[keep][0], trial[keep], table.lines[keep]
    columns = {
        name: _converted(path, table.numbers[entry.column][keep], name, chart)
        for name, entry in chart.channels.items()
    }
    for name in [name for name, values in columns.items() if np.all(np.isnan(values))]:
        column = chart.channels[name].column
        empty = f"{name} holds no number: the column {column!r} is empty; is it the right one?"
        report.add(Kind.SUSPECT, empty)
        report.missing.append(empty)
        del columns[name]
    if not columns:
        raise RecordingError(f"{path}: no channel holds a single value")
    noise = _noise(t, trial, columns, chart, LEAST_NOISE_ROWS)
    rough = _noise(t, trial, columns, chart, LEAST_TOUCH_ROWS)
    _suspect_travel(t, trial, columns, chart, report)
    for rows in stretches_of(trial):
        one = {name: values[rows] for name, values in columns.items()}  # views: corrected in place
        correct_trial(t[rows], one, rough.get("normal_force", 0.0), chart, report)
    fingertip = chart.fingertip if math.isnan(radius) else dataclasses.replace(chart.fingertip, radius=radius)
    if math.isnan(fingertip.radius) and not is_stretch:
        report.add(Kind.NOTE, "the fingertip's radius is unknown; give --radius if it is known")
    report_doubts(t, trial, columns, fingertip.radius, lines, report)
    source = {"file": path.name, "map": chart.name or "command line"}
    source |= {MATERIAL: STRETCH} if is_stretch else {}
    report.place_losses(t, lines, columns, trial)
    ordered = {key: columns[key] for key in RECORDED if key in columns}
    name = path.name.removesuffix(".gz").rsplit(".", 1)[0]
    return Recording(name, t, trial, ordered, fingertip, noise, source, start, report)


def _of_specimen(path: Path, chart: ColumnMap) -> ColumnMap:
    """Return ``chart`` with strain and stress as displacement and force of a specimen of 1 mm by 1 mm^2."""
    channels = dict(chart.channels)
    if channels.keys() & {"displacement", "normal_force"} or not channels.keys() >= STRETCHES.keys():
        raise RecordingError(
            f"{path}: tension against length has a strain and a stress, and nothing beside it"
        )
    for name, channel, size in SPECIMEN:
        entry = channels.pop(name)
        unit, _ = to_si(entry.unit, STRETCHES[name].unit, f"{path}: column {entry.column!r} as {name}")
        channels[channel] = dataclasses.replace(
            entry,
            unit="",
            scale=entry.scale * unit * size,
            offset=entry.offset * size,
            noise=entry.noise * size,
        )
    return dataclasses.replace(chart, channels=channels)


def steps_of(
    path: Path, table: Table, trial: NDArray[np.int64], chart: ColumnMap, report: LoadReport
) -> Recording:
    """Return the recording of unit steps, each trial one: the strain or the stress that is held from t = 0.

    Of a specimen 1 m long and of 1 mm^2 in section: a displacement in m is a strain, a force in N a stress in
    MPa. A table has neither what was before the step nor at once after it: before, all is zero; a strain
    that is held is there at once, and the compliance until its first row is the power of time that goes
    through the rows after it.
    """
    found = STEP_QUANTITIES.keys() & chart.channels.keys()
    if len(found) > 1 or {"displacement", "normal_force"} & chart.channels.keys():
        raise RecordingError(
            f"{path}: a table of a step has a modulus or a compliance, and no force beside it"
        )
    kind = found.pop()
    scale, offset = to_si(chart.time.unit, "s", f"{path}: time column {chart.time.column!r}")
    since = table.numbers[chart.time.column] * scale + offset
    columns = {
        name: _converted(path, table.numbers[e.column], name, chart) for name, e in chart.channels.items()
    }
    steps = []
    for rows in stretches_of(trial):
        keep = usable_rows(np.where(since[rows] >= 0.0, since[rows], np.nan), table.lines[rows], report)
        keep &= columns[kind][rows] > 0.0
        report.rows_kept += int(np.count_nonzero(keep))
        if np.count_nonzero(keep) < LEAST_STEP_ROWS:
            raise RecordingError(
                f"{path}: has fewer than {LEAST_STEP_ROWS} rows of a step with a {kind} above zero"
            )
        one = {name: values[rows][keep] for name, values in columns.items()}
        _suspect_begin(since[rows][keep], report)
        steps.append(
            step_recording(path.name.removesuffix(".gz").rsplit(".", 1)[0], since[rows][keep], one, kind)
        )
    source = {"file": path.name, "map": chart.name or "command line", MATERIAL: steps[0].source[MATERIAL]}
    joined = join_recordings(steps, steps[0].name)
    return dataclasses.replace(joined, source=source, report=report)


def step_recording(name: str, since: Floats, columns: Columns, kind: str) -> Recording:
    """Return the recording of one unit step: ``modulus`` [Pa] or ``compliance`` [1/Pa] and ``since`` [s] it.

    The force of a creep is exact, and what its displacement is wrong by counts as force by the stiffness.
    """
    values, first = columns[kind], float(since[0])
    early = np.zeros(0) if first == 0.0 else np.zeros(1)
    if kind == "modulus":
        t, strain = np.r_[early, since], np.full(early.size + since.size, STEP_STRAIN)
        force = np.r_[np.full(early.size, np.nan), STEP_STRAIN * values / PA_PER_MPA]
        noise = baseline_noise([force[early.size :]], LEAST_STEP_ROWS)
    else:
        some = slice(0, max(LEAST_STEP_ROWS, int(np.searchsorted(since, 3.0 * first))))
        rise = np.polyfit(np.log(since[some]), np.log(values[some]), 1)[0] if first > 0.0 else 0.0
        if first > 0.0:
            early = np.r_[0.0, first * np.geomspace(EARLIEST, 1.0, EARLY_ROWS)[:-1]]
        begun = values[0] * np.maximum(early / max(first, 1e-300), 0.1 * EARLIEST) ** min(max(rise, 0.0), 1.0)
        t, strain = np.r_[early, since], np.r_[begun, values] * STEP_STRAIN / values[0]
        force = np.r_[np.full(early.size, np.nan), np.full(since.size, STEP_STRAIN / values[0] / PA_PER_MPA)]
        noise = baseline_noise([values], LEAST_STEP_ROWS) / values[0] * force[-1]
    before = np.arange(early.size + 1) * 0
    rest = {n: v[np.r_[before, np.arange(since.size)]] for n, v in columns.items() if n != kind}
    at_rest = -min(MIN_SAMPLE_PERIOD_S, EARLIEST * EARLIEST * first) if first else -MIN_SAMPLE_PERIOD_S
    measured = {"displacement": np.r_[0.0, strain], "normal_force": np.r_[0.0, force], **rest}
    t = np.r_[at_rest, t] - at_rest
    return Recording(
        name, t, np.zeros(t.size, dtype=np.int64), measured,
        sensors={"normal_force": noise} if noise > 0.0 else {}, source={MATERIAL: STEPS_HELD[kind]},
    )  # fmt: skip


def _suspect_begin(since: Floats, report: LoadReport) -> None:
    """Report a step whose first rows follow each other closer than they follow the step."""
    first, step = float(since[0]), float(np.median(np.diff(since[:LEAST_STEP_ROWS])))
    grown = float(np.median(np.diff(since[-LEAST_STEP_ROWS:])) / step) if step > 0.0 else 1.0
    if first > LATE_STEPS * step and grown > LATE_GROWTH * float(since[-1]) / first:
        report.add(
            Kind.SUSPECT,
            f"the first row is {first:.4g} s after the step, and the next {step:.3g} s after that: where the "
            "test has a time of its own, make it count from the step",
        )


def _suspect_trials(t: Floats, report: LoadReport) -> None:
    begun = int(np.count_nonzero(np.diff(t) < -0.5 * (np.nanmax(t) - np.nanmin(t))))
    if begun:
        report.add(
            Kind.AMBIGUOUS,
            f"the time begins anew {begun} x, and rows of trials lie over each other; say which column "
            "distinguishes the trials with --map episode=COLUMN, or give each trial as a table of its own",
        )


def _suspect_travel(
    t: Floats, trial: NDArray[np.int64], columns: Columns, chart: ColumnMap, report: LoadReport
) -> None:
    """Report where displacement is the travel of a rig: at first touch it is off by more than is pressed."""
    if not {"displacement", "normal_force"} <= columns.keys():
        return
    entries = chart.channels["displacement"], chart.channels["normal_force"]
    if entries[0].zero != "none" or entries[0].offset:
        return
    off, pressed, rests = [], [], []
    for rows in stretches_of(trial):
        depth, force = columns["displacement"][rows], columns["normal_force"][rows]
        if np.isnan(force[:REST_ROWS]).all():
            continue
        force = force - np.nanmedian(force[:REST_ROWS])
        threshold = max(
            5.0 * baseline_noise([force[:REST_ROWS]], LEAST_TOUCH_ROWS), TOUCH_SHARE * float(np.nanmax(force))
        )
        touch = first_touch(force, threshold)
        if touch and np.nanmax(force) > -np.nanmin(force):  # else its sign is wrong
            off.append(float(depth[touch]))
            pressed.append(float(depth[np.nanargmax(force)]) - off[-1])
            rests.append(float(t[rows][np.argmax(force >= threshold)] - t[rows][0]))
    if off and np.median(np.abs(off)) > np.median(pressed) > 0.0:
        rest = 0.5 * min(rests)
        report.add(
            Kind.SUSPECT,
            f"displacement is {np.median(off):.2g} m where the force begins to rise: it is the travel of a "
            "rig, not the indentation; import with --zero displacement=contact --zero normal_force=baseline "
            f"--baseline {rest:.1g}",
        )


def _check_mapped(path: Path, chart: ColumnMap, header: list[str]) -> None:
    if path.suffix.lower() == ".toml":
        raise RecordingError(
            f"{path}: is TOML, as a model or a map is, and no table; give a table of numbers"
        )
    if len(header) == 1:
        raise RecordingError(
            f"{path}: has only the column {header[0]!r}; say what separates its fields: "
            + _said(chart, "--delimiter ' '", '[table] delimiter = " "')
        )
    if not chart.channels:
        raise RecordingError(
            f"{path}: none of the columns {listed(header)} is called like a channel; "
            "say what they are with --map normal_force=COLUMN or --map-file"
        )
    if chart.time.column not in header:
        known = suggestion(chart.time.column, header)
        raise RecordingError(
            f"{path}: there is no time column {chart.time.column!r}; "
            f"say which one it is with --map t=COLUMN; {known}"
        )


def _trials(table: Table, chart: ColumnMap) -> NDArray[np.int64]:
    if not chart.episode.column:
        return np.zeros(len(table.lines), dtype=np.int64)
    labels = table.words[chart.episode.column]
    number = {label: i for i, label in enumerate(dict.fromkeys(labels))}
    return np.array([number[label] for label in labels], dtype=np.int64)


def _seconds(
    path: Path, table: Table, trial: NDArray[np.int64], chart: ColumnMap, report: LoadReport
) -> Floats:
    """Return the time [s]; a trial whose clock begins anew is put ``gap`` after the one before."""
    scale, offset = to_si(chart.time.unit, "s", f"{path}: time column {chart.time.column!r}")
    t = table.numbers[chart.time.column] * scale + offset
    moved = 0
    if not chart.episode.column:
        lost = table.lost_times * scale + offset
        t = _with_those_lost(t, table.lines, lost, table.lost_lines, report, spread=chart.time.spread)
    for rows in stretches_of(trial):
        if chart.episode.column:
            t[rows] = mended(t[rows], report, spread=chart.time.spread)
        if rows.start and t[rows.start] <= t[rows.start - 1]:
            t[rows] += t[rows.start - 1] + chart.episode.gap - t[rows.start]
            moved += 1
    if moved:
        report.add(Kind.NOTE, f"{moved} trials whose time begins anew were put one after the other")
    return t


def _with_those_lost(
    t: Floats,
    lines: NDArray[np.int64],
    lost: Floats,
    lost_lines: NDArray[np.int64],
    report: LoadReport,
    *,
    spread: bool,
) -> Floats:
    """Return the times ``t``, corrected together with those of rows left out: they show the clock."""
    every = np.concatenate([lines, lost_lines])
    order = np.argsort(every, kind="stable")
    whole = np.concatenate([t, np.where(np.isinf(lost), np.nan, lost)])[order]
    result = mended(whole, report, spread=spread)
    return result[np.argsort(order, kind="stable")][: len(t)]


def _converted(path: Path, values: Floats, name: str, chart: ColumnMap) -> Floats:
    entry = chart.channels[name]
    what = f"{path}: column {entry.column!r} as {name}"
    scale, offset = to_si(entry.unit, IMPORTED[name].unit, what)
    return (values * scale + offset) * entry.scale + entry.offset


def _noise(
    t: Floats, trial: NDArray[np.int64], columns: Columns, chart: ColumnMap, least: int
) -> dict[str, float]:
    """Return the noise as the map states it, else as measured in the baselines of all trials."""
    quiet = [
        slice(rows.start, rows.start + int(np.sum(t[rows] < t[rows.start] + chart.baseline.duration)))
        for rows in stretches_of(trial)
    ]
    noise: dict[str, float] = {}
    for name, values in columns.items():
        std = chart.channels[name].noise or baseline_noise([values[rows] for rows in quiet], least)
        if std > 0.0 and name != "slip":
            noise[noise_name(name)] = std
    return noise
