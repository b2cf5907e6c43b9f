"""Many recordings at once: which hand, which pad, which effect, since when."""

from vegrip.identification.fleet.row import (
    Finding,
    Found,
    Row,
    examine_recording,
    find_recordings,
    summarize_rows,
)
from vegrip.identification.fleet.workers import run

__all__ = ["Finding", "Found", "Row", "examine_recording", "find_recordings", "run", "summarize_rows"]
