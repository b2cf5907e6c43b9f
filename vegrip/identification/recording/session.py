"""Sessions: the recordings of several fingers, and what the node said of them."""

import heapq
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.folder import TOML, read_recording
from vegrip.identification.recording.report import LoadReport
from vegrip.identification.recording.table import Layout, read_header, read_table
from vegrip.messages import FingertipState


def read_fingers(folder: Path | str, *, announce: bool = True) -> dict[str, Recording]:
    """Return the recordings in ``folder`` by finger: of a session, or the one that it is itself.

    Raises:
        RecordingError: there is none, or one of them cannot be read.

    """
    folder = Path(folder)
    if (folder / TOML).exists():
        recording = read_recording(folder, announce=announce)
        return {recording.fingertip.name: recording}
    found = sorted(path.parent for path in folder.glob(f"*/{TOML}"))
    if not found:
        raise RecordingError(f"{folder}: holds no recording; a recording is a folder with {TOML}")
    recordings = [read_recording(each, announce=announce) for each in found]
    return {recording.fingertip.name: recording for recording in recordings}


def merged_states(fingers: Mapping[str, Recording], start: int = 0) -> Iterator[FingertipState]:
    """Yield the states of all fingers in the order of their stamps; t = 0 at ``start`` [ns]."""
    streams = [recording.states(finger, start) for finger, recording in fingers.items()]
    return heapq.merge(*streams, key=lambda state: state.stamp)


def read_output(path: Path | str) -> dict[str, NDArray[Any]]:
    """Read a table of outputs, such as ``slip_margin.csv``, by column: float64, or text where it is text.

    Raises:
        RecordingError: missing or damaged.

    """
    path = Path(path)
    layout = Layout(sealed=True)
    report = LoadReport()
    names = read_header(path, layout)
    words = read_table(path, [], names, layout, report).words
    return {name: _array(cells) for name, cells in words.items()}


def _array(cells: list[str]) -> NDArray[Any]:
    try:
        return np.array([cell or "nan" for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells)
