"""Why a node has ended that could not go on: kept in the runtime folder for some minutes.

A node that could not open its bus, or was killed, cannot report on it; ``vegrip lifecycle`` and the monitor
show the reason, until a node of its name starts again.
"""

import contextlib
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from vegrip.host.folders import runtime_folder
from vegrip.whole_file import write_whole

SUFFIX = ".end"
KEPT_S = 600.0  # [s] an older report is of another run, and says nothing of now


@dataclass(frozen=True)
class ExitReport:
    """What is known of a node that is finalized."""

    name: str  # in full, with namespace
    program: str
    reason: str  # one sentence
    exit_code: int


def write_report(words: ExitReport) -> None:
    """Write ``words`` down; a folder that takes nothing keeps none."""
    with contextlib.suppress(OSError):
        write_whole(_file(words.name), json.dumps(asdict(words)))


def remove_report(name: str) -> None:
    with contextlib.suppress(OSError):
        _file(name).unlink(missing_ok=True)


def read_reports() -> dict[str, ExitReport]:
    found = [_read(path) for path in sorted(runtime_folder("nodes").glob(f"*{SUFFIX}"))]
    return {words.name: words for words in found if words is not None}


def _file(name: str) -> Path:
    return runtime_folder("nodes") / f"{name.strip('/').replace('/', '.')}{SUFFIX}"


def _read(path: Path) -> ExitReport | None:
    try:
        if time.time() - path.stat().st_mtime > KEPT_S:
            path.unlink()
            return None
        return ExitReport(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, RecursionError):  # removed at this moment, or of another version
        return None
