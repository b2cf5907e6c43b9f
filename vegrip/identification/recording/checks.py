"""Conditions on a table of measurements: those of a recording, and those of plausible units."""

from bisect import bisect_left
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import RECORDED
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.table import report_if
from vegrip.types import Floats

MIN_SAMPLE_PERIOD_S, MAX_SAMPLE_PERIOD_S = 2e-5, 0.9
"""[s] A fingertip that is sampled more often or more rarely may have its time in another unit."""

OPPOSED: Final = 0.5
"""Correlation of displacement and force against each other, from which a sign is wrong, and with each other,
from which the two are of one contact (origin: rule)."""
MIN_SUSPECT_ROWS: Final = 50
MOSTLY: Final = 3.0
"""How much farther a force goes to the wrong side, more than any pull of adhesion (origin: rule)."""
MIN_BULGE: Final = 0.03
"""Of the curve of force over displacement to the side where a contact grows softer; measured and simulated
recordings have -0.2 to -0.07, with the columns exchanged 0.06 to 0.19 (origin: measured)."""
LEAST_MODULUS, LARGEST_MODULUS = 10.0, 1e10
"""[Pa] between which the effective modulus of anything that a tip touches lies: gels and metals."""
SOFT_MODULUS, HARD_MODULUS = 1e3, 2e8
"""[Pa] between which that of a soft pad lies, gel to hard rubber; outside it is asked about."""
LEAST_FRICTION, LARGEST_FRICTION = 0.01, 20.0
"""Of anything that slides under a load, those of ``coulomb_friction``."""
PRESSED_SHARE: Final = 0.1
"""Of the largest normal force, from which a load counts as pressed (origin: rule)."""
AIRLESS = (
    "the fingertip is never in the air, so neither the zeros of the sensors are known nor what the "
    "contact remembers from before, and what is fitted makes up for both: record from before the "
    "touch, as when the hand releases and grips again"
)

FAR: Final = 1.0
APART: Final = 0.5
BACK: Final = 0.2
"""Times the range of all others, from which a value that stands several times is a mark: anywhere, or where
the values on both sides of it agree but for a share of that (origin: rule)."""
OF_SLIP: Final = ("slip", "slip_speed")
"""Channels that stand at one value and go to another."""
LEAST_MARKS: Final = 2

Lines = NDArray[np.int64]


def usable_rows(t: Floats, lines: Lines, report: LoadReport, what: str = "") -> NDArray[np.bool_]:
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


def kept_rows(
    path: Path,
    t: Floats,
    episode: NDArray[np.int64],
    columns: Mapping[str, Floats],
    radius: float,
    lines: Lines,
    report: LoadReport,
) -> tuple[Floats, NDArray[np.int64], dict[str, Floats]]:
    """Return time, episode and columns of the rows whose stamps grow, and report every doubt about them.

    Columns in which nothing ever stands were not measured: a recorder writes all.

    Raises:
        RecordingError: no row, or no value, is left.

    """
    keep = usable_rows(t, lines, report)
    report.rows_kept = int(np.count_nonzero(keep))
    if not report.rows_kept:
        raise RecordingError(f"{path}: no usable row; {report.summary()}")
    columns = {name: values[keep] for name, values in columns.items()}
    columns = {name: values for name, values in columns.items() if not np.all(np.isnan(values))}
    if not columns:
        raise RecordingError(f"{path}: no channel holds a single value")
    report_doubts(t[keep], episode[keep], columns, radius, lines[keep], report)
    report.place_losses(t[keep], lines[keep], columns, episode[keep])
    return t[keep], episode[keep], columns


def stretches_of(episode: NDArray[np.int64]) -> Iterator[slice]:
    edges = [0, *(np.flatnonzero(np.diff(episode)) + 1).tolist(), len(episode)]
    return (slice(low, high) for low, high in pairwise(edges))


def longest_increasing(values: Floats) -> NDArray[np.int64]:
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
    t: Floats,
    episode: NDArray[np.int64],
    columns: Mapping[str, Floats],
    radius: float,
    lines: Lines,
    report: LoadReport,
) -> None:
    """Report missing values and what suggests a wrong unit, sign or column; nothing is left out for it."""
    suspected = list(suspect_columns(episode, columns, radius))
    for sentence in suspected or asked(columns, radius):
        report.add(Kind.SUSPECT, sentence)
    if is_airless(columns):
        report.add(Kind.AIRLESS, AIRLESS)
    for name, values in columns.items():
        report_if(report, Kind.MISSING, name, lines[np.isnan(values)])
        if name not in OF_SLIP and (mark := mark_in(values)) is not None:
            said = (
                f"{name} is {mark:.6g} in {np.count_nonzero(values == mark)} of {len(values)} rows, far from "
                "all others: if that says that nothing was measured, leave those cells empty"
            )
            report.add(Kind.SUSPECT, said)
            report.missing.append(said)
        quantity = RECORDED[name]
        outside = (values < quantity.low) | (values > quantity.high)
        bounds = f"{name} outside {quantity.low:g} .. {quantity.high:g} {quantity.unit}"
        report_if(report, Kind.IMPLAUSIBLE, bounds, lines[outside])
    for name in ("displacement", "contact_radius"):
        if name in columns and radius > 0:
            larger = f"{name} larger than the fingertip's radius of {radius:g} m"
            report_if(report, Kind.IMPLAUSIBLE, larger, lines[columns[name] > radius])
    step = float(np.median(np.diff(t))) if len(t) >= MIN_SUSPECT_ROWS else MAX_SAMPLE_PERIOD_S
    if not MIN_SAMPLE_PERIOD_S <= step <= MAX_SAMPLE_PERIOD_S:
        report.add(Kind.IMPLAUSIBLE, f"t advances by {step:g} s a row", [int(lines[0])])


def mark_in(values: Floats) -> float | None:
    """Return the value that stands several times, far from all others, as -9999 for what was not measured."""
    known = values[np.isfinite(values)]
    for mark in (known.min(), known.max()) if known.size >= MIN_SUSPECT_ROWS else ():
        others = known[known != mark]
        count = known.size - others.size
        if not mark or count < LEAST_MARKS or not others.size:
            continue
        away, span = float(np.min(np.abs(others - mark))), float(np.ptp(others))
        if (away > FAR * span > 0.0 and 2 * count <= known.size) or (
            away > APART * span > 0.0 and _is_left_again(known, mark, BACK * away)
        ):
            return float(mark)
    return None


def _is_left_again(values: Floats, mark: float, close: float) -> bool:
    """Whether before and after each stretch of ``mark`` the values are within ``close`` of each other."""
    edges = np.flatnonzero(np.diff(np.r_[False, values == mark, False]))
    inner = [(low, high) for low, high in edges.reshape(-1, 2).tolist() if low > 0 and high < len(values)]
    return bool(inner) and all(abs(values[low - 1] - values[high]) <= close for low, high in inner)


def suspect_columns(
    episode: NDArray[np.int64], columns: Mapping[str, Floats], radius: float
) -> Iterator[str]:
    """Yield what normal force and displacement cannot be to each other, with what answers it in an import.

    A contact pushes back the harder the deeper it is pressed, it grows stiffer on the way, and of the work
    that is put in, ``W = sum N d(delta) > 0`` over a press, some is lost. Of two columns that are exchanged,
    the curve bends to the other side and ``W < 0``; a lag of the force alone turns only ``W``, a creep under
    a constant force only the bend.
    """
    if not {"displacement", "normal_force"} <= columns.keys():
        return
    known = np.isfinite(columns["displacement"]) & np.isfinite(columns["normal_force"])
    depth, force = columns["displacement"][known], columns["normal_force"][known]
    if depth.size < MIN_SUSPECT_ROWS or not np.ptp(depth) > 0.0 or not np.ptp(force) > 0.0:
        return
    together = float(np.corrcoef(depth, force)[0, 1])
    is_negative = -force.min() > MOSTLY * force.max()
    if together < -OPPOSED:
        name = "normal_force" if -force.min() > force.max() else "displacement"
        yield (
            "the force falls where the tip goes deeper: one of the two has the wrong sign (compression and "
            f"indentation are positive); import with --negate {name}"
        )
    elif together > OPPOSED and is_negative:
        yield (
            "force and displacement are negative where the tip is pressed: both have the wrong sign; import "
            "with --negate normal_force --negate displacement"
        )
    elif together > OPPOSED and _is_exchanged(episode[known], depth, force):
        yield (
            "force and displacement look exchanged: the contact grows softer with the depth, and gives back "
            "more work than is put in; exchange their columns in --map"
        )
    elif together > OPPOSED:
        yield from _impossible(columns, depth, force, radius)


def _impossible(columns: Mapping[str, Floats], depth: Floats, force: Floats, radius: float) -> Iterator[str]:
    modulus = _modulus(depth, force, radius)
    if modulus < LEAST_MODULUS or modulus > LARGEST_MODULUS:
        at = int(np.argmax(force))
        yield (
            f"the stiffness cannot be: {force[at]:.3g} N at {depth[at]:.3g} m needs a modulus of "
            f"{modulus:.1g} Pa; check --unit of both, and --radius"
        )
    friction = _friction(columns, radius)
    if friction < LEAST_FRICTION or friction > LARGEST_FRICTION:
        yield (
            f"the friction cannot be: it slides under {friction:.2g} times the normal force; check --unit of "
            "the forces"
        )


def asked(columns: Mapping[str, Floats], radius: float) -> Iterator[str]:
    """Yield what a normal force and a displacement seldom are to each other, as a question."""
    if not {"displacement", "normal_force"} <= columns.keys():
        return
    known = np.isfinite(columns["displacement"]) & np.isfinite(columns["normal_force"])
    if np.count_nonzero(known) < MIN_SUSPECT_ROWS:
        return
    modulus = _modulus(columns["displacement"][known], columns["normal_force"][known], radius)
    if modulus < SOFT_MODULUS or modulus > HARD_MODULUS:
        yield (
            f"the pad has a modulus of {modulus:.1g} Pa, softer than a gel or harder than rubber: are the "
            "units right? If not, say --unit of both, and --radius"
        )


def _modulus(depth: Floats, force: Floats, radius: float) -> float:
    """Return the effective modulus [Pa] of a sphere that is pressed so at its largest force; NaN if none."""
    at = int(np.argmax(force))
    if not (radius > 0.0 and depth[at] > 0.0):
        return float("nan")
    return float(force[at]) / (4.0 / 3.0 * float(np.sqrt(radius * depth[at] ** 3)))


def _friction(columns: Mapping[str, Floats], radius: float) -> float:
    """Return what slides over the normal force, with the torque at the radius; NaN if nothing slides."""
    slip, force = columns.get("slip"), columns["normal_force"]
    levers = {"tangential_force_x": 1.0, "tangential_force_y": 1.0, "torque_z": radius}
    loads = [columns[name] / lever for name, lever in levers.items() if name in columns and lever > 0.0]
    if slip is None or not loads or ("torque_z" in columns and not radius > 0.0):
        return float("nan")
    load = np.sqrt(np.sum(np.square(loads), axis=0))
    slides = (slip == 1.0) & (force > PRESSED_SHARE * np.nanmax(force)) & np.isfinite(load)
    return float(np.median(load[slides] / force[slides])) if slides.any() else float("nan")


def is_airless(columns: Mapping[str, Floats]) -> bool:
    """Whether both force and displacement stay well on the side where the tip is pressed."""
    names = {"displacement", "normal_force"}
    if not names <= columns.keys():
        return False
    pressed = [columns[name][np.isfinite(columns[name])] for name in names]
    return all(one.size >= MIN_SUSPECT_ROWS and one.min() > PRESSED_SHARE * one.max() for one in pressed)


def _is_exchanged(episode: NDArray[np.int64], depth: Floats, force: Floats) -> bool:
    work, bulges, sizes = 0.0, [], []
    for rows in stretches_of(episode):
        d, f = depth[rows] - depth[rows][0], force[rows] - force[rows][0]
        across, up = float(np.ptp(d)), float(np.ptp(f))
        if across * up == 0.0:
            continue
        x, y = (d - d.min()) / across, (f - f.min()) / up
        pressed = x > 0.1
        bulges.append(float(np.mean((y - x)[pressed])))
        sizes.append(across * up)
        if abs(d[-1]) < 0.1 * across or abs(f[-1]) < 0.1 * up:
            work += float(np.trapezoid(f, d))
    return bool(sizes) and work < 0.0 and float(np.average(bulges, weights=sizes)) > MIN_BULGE
