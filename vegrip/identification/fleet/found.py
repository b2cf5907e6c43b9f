"""Which recordings there are below a folder, and of which hand, pad and date each is.

What ``[source]`` of ``recording.toml`` says counts: ``hand``, ``pad`` and ``date`` (or ``began``, as the
recorder writes it). Else the hand is the folder right below the one that is looked through, the pad the name
of the fingertip, and the date that of the file, which is marked as such. A recording that lies right below
that folder and says neither may be of any pad: it is not put together with others.
"""

import hashlib
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from vegrip.config import read_toml
from vegrip.errors import ConfigError, UsageError
from vegrip.identification.recording.folder import CSV, TOML

DATES = ("date", "began", "recorded")


@dataclass(frozen=True)
class Found:
    """A folder that should be a recording."""

    path: str
    hand: str
    pad: str
    date: str  # ISO 8601, the day or the instant
    dated_by: str  # "recording" or "file"
    fingerprint: str  # of the files' size and time
    is_alone: bool = False  # it does not say of which pad it is, and counts as one by itself


def find_recordings(folder: Path) -> list[Found]:
    """Return every recording below ``folder``, by date.

    Raises:
        UsageError: there is no such folder, or no recording in it.

    """
    if not folder.is_dir():
        raise UsageError(f"{folder}: there is no such folder")
    paths = sorted(path.parent for path in folder.rglob(TOML))
    if not paths:
        raise UsageError(f"{folder}: no recording in it; a recording is a folder with {TOML} and {CSV}")
    return sorted((_found(path, folder) for path in paths), key=lambda one: (one.date, one.path))


def _found(path: Path, root: Path) -> Found:
    try:
        about = read_toml(path / TOML)
    except ConfigError:
        about = {}  # the diagnosis says what is wrong
    source, tip = (_table(about.get(name)) for name in ("source", "fingertip"))
    parts = path.relative_to(root).parts
    told = next((text for key in DATES if (text := _date(source.get(key)))), "")
    is_alone = len(parts) < 2 and not {"hand", "pad"} & source.keys()
    return Found(
        str(path),
        str(source.get("hand", parts[0] if len(parts) > 1 else root.resolve().name)),
        path.name if is_alone else str(source.get("pad", tip.get("name", path.name))),
        told or datetime.fromtimestamp(_changed(path), UTC).isoformat(timespec="seconds"),
        "recording" if told else "file",
        _fingerprint(path),
        is_alone,
    )


def _table(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _date(value: Any) -> str:
    """Return a date as ISO text, empty when it is none."""
    if isinstance(value, date):  # a datetime is one, too
        return value.isoformat()
    try:
        return datetime.fromisoformat(str(value)).isoformat() if value else ""
    except ValueError:
        return ""


def _files(path: Path) -> list[Path]:
    return sorted(p for name in (TOML, CSV, f"{CSV}.gz") if (p := path / name).is_file())


def _changed(path: Path) -> float:
    return max(p.stat().st_mtime for p in _files(path))


def _fingerprint(path: Path) -> str:
    told = [(p.name, p.stat().st_size, p.stat().st_mtime_ns) for p in _files(path)]
    return hashlib.sha256(repr(told).encode()).hexdigest()[:16]
