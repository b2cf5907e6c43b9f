"""Sessions: the recordings of several fingers and the outputs of the node; read, summarised, replaced."""

import contextlib
import heapq
import logging
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vegrip.config import read_toml
from vegrip.errors import ConfigError, RecordingError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.folder import CSV, TOML, existing_folder, read_recording
from vegrip.identification.recording.report import LoadReport
from vegrip.identification.recording.table import Layout, Progress, read_header, read_table
from vegrip.identification.recording.writer import FILE_OF_MESSAGE, SESSION
from vegrip.messages import FingertipState

log = logging.getLogger(__name__)
COLUMNS = 420  # of the traces
FAULTS = ("input_hold", "fail_safe", "untrusted", "inactive")
Table = dict[str, NDArray[Any]]
MARKS: Final = (SESSION, TOML, CSV, f"{CSV}.gz")
OURS: Final = tuple(dict.fromkeys((*MARKS, *FILE_OF_MESSAGE.values())))


def finger_folders(folder: Path) -> list[Path]:
    """Return the folders that hold a recording: ``folder`` itself, or those of a session in it."""
    if (folder / TOML).exists():
        return [folder]
    found = sorted(path.parent for path in existing_folder(folder).glob(f"*/{TOML}"))
    if not found:
        raise RecordingError(f"{folder}: holds no recording; a recording is a folder with {TOML}")
    return found


def read_fingers(
    folder: Path | str, *, announce: bool = True, progress: Progress = lambda _: None
) -> dict[str, Recording]:
    """Return the recordings in ``folder`` by finger: of a session, or the one that it is itself.

    ``announce`` and ``progress`` are those of :func:`read_recording`.
    """
    places = finger_folders(Path(folder))
    found = [read_recording(place, announce=announce, progress=progress) for place in places]
    return {recording.fingertip.name: recording for recording in found}


def merge_states(fingers: Mapping[str, Recording], start: int = 0) -> Iterator[FingertipState]:
    """Yield the states of all fingers in the order of their stamps; t = 0 at ``start`` [ns]."""
    streams = [recording.states(finger, start) for finger, recording in fingers.items()]
    return heapq.merge(*streams, key=lambda state: state.stamp)


def read_output(path: Path | str) -> dict[str, NDArray[Any]]:
    """Read a table of outputs, such as ``slip_margin.csv``, by column: float64, or text where it is text."""
    return {name: _array(cells) for name, cells in read_cells(Path(path)).items()}


def read_cells(path: Path) -> dict[str, list[str]]:
    """Read a table of outputs by column, each cell as written; rows left out are logged as a warning."""
    layout, report = Layout(sealed=True), LoadReport()
    words = read_table(path, [], read_header(path, layout), layout, report).words
    report.rows_kept = len(next(iter(words.values())))
    if report.rows_lost:
        log.warning("%s: %s", path, report.summary())
    return words


def _array(cells: list[str]) -> NDArray[Any]:
    try:
        return np.array([cell or "nan" for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells)


def is_run(folder: Path) -> bool:
    return (folder / SESSION).is_file()


def summarise_run(folder: Path) -> dict[str, Any]:
    """Return the run in ``folder`` as JSON has it."""
    try:
        about = read_toml(folder / SESSION)
    except ConfigError as error:
        raise RecordingError(str(error)) from None
    fingers = {path.parent.name: _finger(path.parent) for path in sorted(folder.glob("*/force_command.csv"))}
    if not fingers:
        raise RecordingError(f"{folder}: holds no commands of a node; record one with `vegrip launch demo`")
    nodes = folder / "diagnostics.csv"
    return {
        "name": folder.name,
        "folder": str(folder),
        "about": {key: str(value) for key, value in about.items() if not isinstance(value, dict)},
        "fingers": fingers,
        "nodes": _nodes(read_output(nodes)) if nodes.is_file() else {},
    }


def _finger(folder: Path) -> dict[str, Any]:
    command = read_output(folder / "force_command.csv")
    tables = {name: _output(folder / f"{name}.csv") for name in ("slip_margin", "contact", "model_health")}
    margin, contact, health = tables["slip_margin"], tables["contact"], tables["model_health"]
    reasons = command["reason"].astype(str)
    names, counts = np.unique(reasons, return_counts=True)
    slips = int(np.count_nonzero((reasons[1:] == "slip") & (reasons[:-1] != "slip")))
    bound = margin["lower_bound"] if margin else np.empty(0)
    known = bound[np.isfinite(bound)]
    result: dict[str, Any] = {
        "duration": _span(command["t"]),
        "commands": len(reasons),
        "slips": slips,
        "force_mean": _number(np.mean(command["normal_force"])),
        "force_max": _number(np.max(command["normal_force"])),
        "bound_lowest": _number(known.min()) if known.size else None,
        "bound_q05": _number(np.quantile(known, 0.05)) if known.size else None,
        "below_zero": _number(np.mean(known < 0.0)) if known.size else None,
        "reasons": {str(n): _number(c / len(reasons)) for n, c in zip(names, counts, strict=True)},
        "fault": _number(np.mean(np.isin(reasons, FAULTS))),
        "traces": {
            "command": _trace(command["t"], command["normal_force"]),
            "bound": _trace(margin["t"], bound) if margin else None,
            "margin": _trace(margin["t"], margin["margin"]) if margin else None,
            "normal_force": _trace(contact["t"], contact["normal_force"]) if contact else None,
        },
    }
    if health:
        result |= _health(health)
    return result


def _health(health: Table) -> dict[str, Any]:
    names, counts = np.unique(health["condition"].astype(str), return_counts=True)
    suspects = health["suspect"].astype(str)
    return {
        "conditions": {str(n): _number(c / counts.sum()) for n, c in zip(names, counts, strict=True)},
        "consistent": _number(np.mean(health["consistent"].astype(float))),
        "suspects": sorted({str(name) for name in suspects} - {"", "nan"}),
    }


def _nodes(table: Table) -> dict[str, Any]:
    names = table["node"].astype(str)
    return {str(name): _node({key: table[key][names == name] for key in table}) for name in np.unique(names)}


def _node(table: Table) -> dict[str, Any]:
    def most(key: str) -> float | None:
        values = table[key].astype(float)
        return _number(values[np.isfinite(values)].max()) if np.isfinite(values).any() else None

    def median(key: str) -> float | None:
        values = table[key].astype(float)
        return _number(np.nanmedian(values)) if np.isfinite(values).any() else None

    return {
        "duration": _span(table["t"]),
        "rate_out": median("rate_out"),
        "latency_p50": median("latency_p50"),
        "latency_p99": median("latency_p99"),
        "latency_max": most("latency_max"),
        "deadline_misses": most("deadline_misses"),
        "dropped": most("dropped"),
        "rejected": str(table["rejected"].astype(str)[-1]).replace("nan", ""),
    }


def _output(path: Path) -> Table:
    return read_output(path) if path.is_file() else {}


def _trace(t: NDArray[Any], values: NDArray[Any]) -> dict[str, list[float]] | None:
    finite = np.isfinite(values)
    t, values = t[finite], values[finite]
    if t.size < 2:
        return None
    edges = np.linspace(t[0], t[-1], COLUMNS + 1)
    starts = np.unique(np.searchsorted(t, edges[:-1]))
    return {
        "time": [float(f"{v:.5g}") for v in t[starts]],
        "low": [float(f"{v:.4g}") for v in np.minimum.reduceat(values, starts)],
        "high": [float(f"{v:.4g}") for v in np.maximum.reduceat(values, starts)],
    }


def _span(t: NDArray[Any]) -> float:
    return float(t[-1] - t[0]) if t.size else 0.0


def _number(value: Any) -> float:
    return float(f"{float(value):.4g}")


def holds_recording(folder: Path) -> bool:
    """Return whether ``folder`` is a recording or a session, or what is left of one."""
    return any((folder / mark).is_file() for mark in MARKS)


@contextlib.contextmanager
def replaced(folder: Path) -> Iterator[None]:
    """Set the recording in ``folder`` aside while another is written, and put it back if that fails.

    Nothing else in the folder is touched.
    """
    if not holds_recording(folder):
        yield
        return
    with _beside(folder) as aside:
        _move(folder, aside)
        try:
            yield
        except BaseException:
            with _beside(folder) as half:
                _move(folder, half)
            _move(aside, folder)
            raise


@contextlib.contextmanager
def _beside(folder: Path) -> Iterator[Path]:
    try:
        place = tempfile.TemporaryDirectory(prefix=f".{folder.name}-", dir=folder.parent)
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be replaced ({error.strerror or error})") from None
    with place as name:
        yield Path(name)


def _move(folder: Path, target: Path) -> None:
    try:
        for file in _files(folder):
            place = target / file.relative_to(folder)
            place.parent.mkdir(parents=True, exist_ok=True)
            file.rename(place)
            if file.parent != folder:
                with contextlib.suppress(OSError):
                    file.parent.rmdir()  # of a finger, when nothing else is in it
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be replaced ({error.strerror or error})") from None


def _files(folder: Path) -> list[Path]:
    is_session = (folder / SESSION).is_file()
    fingers = sorted(path.parent for path in folder.glob(f"*/{TOML}")) if is_session else []
    return [place / name for place in (*fingers, folder) for name in OURS if (place / name).is_file()]
