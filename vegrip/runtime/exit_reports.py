"""Why a node has ended that could not go on: kept in the runtime folder until one of its name starts again.

The bus that a node could not open cannot be told on it; ``vegrip lifecycle`` can be asked.
"""

import contextlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path

from vegrip.host.runtime_folder import runtime_folder

SUFFIX = ".end"


@dataclass(frozen=True)
class LastWords:
    """What is known of a node that is finalized."""

    name: str  # in full, with namespace
    program: str
    reason: str  # one sentence
    exit_code: int


def leave(words: LastWords) -> None:
    """Write ``words`` down; a folder that takes nothing keeps none."""
    with contextlib.suppress(OSError):
        _file(words.name).write_text(json.dumps(asdict(words)), encoding="utf-8")


def forget(name: str) -> None:
    """Remove the last words of ``name``: it lives again."""
    with contextlib.suppress(OSError):
        _file(name).unlink(missing_ok=True)


def last_words() -> dict[str, LastWords]:
    """Return the last words of all nodes that ended badly and have not come back, by full name."""
    found = [_read(path) for path in sorted(runtime_folder("nodes").glob(f"*{SUFFIX}"))]
    return {words.name: words for words in found if words is not None}


def _file(name: str) -> Path:
    return runtime_folder("nodes") / f"{name.strip('/').replace('/', '.')}{SUFFIX}"


def _read(path: Path) -> LastWords | None:
    try:
        return LastWords(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):  # removed at this moment, or of another version
        return None
