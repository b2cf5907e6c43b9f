"""The recordings below a folder, a row for each that says what was found, and a ledger of the rows."""

import csv
import hashlib
import io
import json
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from vegrip import __version__
from vegrip.config import read_toml
from vegrip.errors import ConfigError, DeviceError, RecordingError, VegripError
from vegrip.identification.recording.folder import CSV, TOML, existing_folder
from vegrip.jsonable import jsonable
from vegrip.whole_file import writing

DATES = ("date", "began", "recorded")
FAILED = "failed"


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
    """Return every recording below ``folder``, by date, and of which hand and pad each is.

    What ``[source]`` of ``recording.toml`` says counts: ``hand``, ``pad`` and ``date`` (or ``began``, as the
    recorder writes it). Else the hand is the folder right below the one that is looked through, the pad the
    name of the fingertip, and the date that of the file, which is marked as such. A recording that lies right
    below that folder and says neither may be of any pad: it is not put together with others.
    """
    paths = sorted(path.parent for path in existing_folder(folder).rglob(TOML))
    if not paths:
        raise RecordingError(f"{folder}: no recording in it; a recording is a folder with {TOML} and {CSV}")
    return sorted((_found(path, folder) for path in paths), key=lambda one: (one.date, one.path))


def _found(path: Path, root: Path) -> Found:
    try:
        about = read_toml(path / TOML)
    except ConfigError:
        about = {}  # the diagnosis says what is wrong
    sections = (about.get(name) for name in ("source", "fingertip"))
    source, tip = (one if isinstance(one, dict) else {} for one in sections)
    parts = path.relative_to(root).parts
    stored = next((text for key in DATES if (text := _date(source.get(key)))), "")
    changed = max(p.stat().st_mtime for p in _files(path))
    is_alone = len(parts) < 2 and not {"hand", "pad"} & source.keys()
    return Found(
        str(path),
        str(source.get("hand", parts[0] if len(parts) > 1 else root.resolve().name)),
        path.name if is_alone else str(source.get("pad", tip.get("name", path.name))),
        stored or datetime.fromtimestamp(changed, UTC).isoformat(timespec="seconds"),
        "recording" if stored else "file",
        _fingerprint(path),
        is_alone,
    )


def _date(value: Any) -> str:
    if isinstance(value, date):  # a datetime is one, too
        return value.isoformat()
    try:
        return datetime.fromisoformat(str(value)).isoformat() if value else ""
    except ValueError:
        return ""


def _files(path: Path) -> list[Path]:
    return sorted(p for name in (TOML, CSV, f"{CSV}.gz") if (p := path / name).is_file())


def _fingerprint(path: Path) -> str:
    stored = [(p.name, p.stat().st_size, p.stat().st_mtime_ns) for p in _files(path)]
    return hashlib.sha256(repr(stored).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Row:
    """The verdict on one recording, or why there is none."""

    path: str  # of its folder
    verdict: str  # of the diagnosis, or "failed"
    effects: tuple[str, ...] = ()  # what was named; a set that was not separated is one text, "a or b"
    sizes: dict[str, float] = field(default_factory=dict)  # parameters of what was named
    before: float = float("nan")  # error in units of the noise; NaN when it failed
    after: float = float("nan")
    note: str = ""  # why it failed, or what is left that nothing explains
    doubts: tuple[str, ...] = ()  # what else may have caused what was named
    lost: str = ""  # what of the recording could not be read, and was left out
    is_machine_failure: bool = False  # whether the machine was the reason, so that another run tries it again


def examine_recording(path: str, model: str = "") -> Row:
    """Diagnose the recording in ``path``; ``model`` is a file to start from. Nothing is raised.

    A recording that is too short or too faulty to name anything has failed: that it shows no effect says
    nothing about its pad.
    """
    from vegrip.identification.diagnosis import diagnose  # noqa: PLC0415 (in the worker, not in the command)
    from vegrip.identification.recording import read_recording  # noqa: PLC0415
    from vegrip.identification.recording.report import MISSING  # noqa: PLC0415
    from vegrip.model import read_model  # noqa: PLC0415

    for needed in (path, model or path):
        if not Path(needed).exists():
            return Row(
                path, FAILED, note=f"the process that examines it sees no {needed}", is_machine_failure=True
            )
    try:
        recording = read_recording(Path(path), announce=False)
        is_whole = not recording.report.rows_lost and MISSING not in recording.source
        lost = "" if is_whole else "; ".join(line.strip() for line in recording.report.summary().splitlines())
        found = diagnose(recording, read_model(Path(model)) if model else None, threads=1)
        grave = [one.text for one in found.doubts if one.is_grave]
        if grave:
            return Row(path, FAILED, note="; ".join(grave), lost=lost)
        verdict = found.verdict
        values = found.model.values
        unsure = found.indistinguishable if verdict == "ambiguous" else []
        effects = (*found.named, *(" or ".join(sorted(group)) for group in unsure))
        taken = [one.candidate.effect for one in found.search.accepted]
        sizes = {p.symbol: values[p.symbol].value for e in taken for p in e.parameters if p.null is not None}
        left = found.unexplained
        note = f"depends on {left.variable}" if verdict == "unexplained" and left is not None else ""
        error = found.error
    except (DeviceError, MemoryError, OSError) as wrong:
        return Row(path, FAILED, note=f"{type(wrong).__name__}: {wrong}", is_machine_failure=True)
    except VegripError as wrong:
        return Row(path, FAILED, note=str(wrong))
    except Exception as wrong:  # noqa: BLE001 (one recording must not stop the others)
        return Row(path, FAILED, note=f"{type(wrong).__name__}: {wrong}")
    doubts = tuple(one.text for one in found.doubts)
    return Row(path, verdict, effects, sizes, error["before"], error["after"], note, doubts, lost)


class Ledger:
    """Rows of what has been examined already: a file of JSON lines, so that a run that was stopped goes on.

    Args:
        path: of the file; made when it is not there.
        model: text of the model file that diagnoses start from; other models have other lines.

    """

    def __init__(self, path: Path, model: str = "") -> None:
        self.path = path
        self._context = hashlib.sha256(f"{__version__}\n{model}".encode()).hexdigest()[:16]
        self._known: dict[str, Row] = {}
        if path.exists():
            self._read()

    def row(self, found: Found) -> Row | None:
        """Return what is known of a recording as it is now; None when it has to be examined."""
        return self._known.get(self._key(found))

    def add(self, found: Found, row: Row) -> None:
        """Write a row down at once, unless only the machine kept the recording from being examined."""
        if row.is_machine_failure:
            return
        self._known[self._key(found)] = row
        stored = jsonable(asdict(row))
        with writing(self.path), self.path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps({"key": self._key(found), **stored}) + "\n")

    def _key(self, found: Found) -> str:
        return f"{self._context}:{found.fingerprint}:{found.path}"

    def _read(self) -> None:
        for line in self.path.read_text(encoding="utf-8").splitlines():
            try:
                stored = json.loads(line)
                key = stored.pop("key")
                stored |= {name: tuple(stored[name]) for name in ("effects", "doubts")}
                stored |= {name: math.nan for name in ("before", "after") if stored[name] is None}
                self._known[key] = Row(**stored)
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
                continue


NONE = "none"
UNEXPLAINED = "unexplained"


@dataclass(frozen=True)
class Finding:
    """One effect of one pad."""

    hand: str
    pad: str
    effect: str  # its name, a set "a or b", "unexplained", "none", or "failed"
    # date of the first recording from which on it was always found; of the first one if it is found no more
    since: str
    until: str  # date of the last recording that shows it
    present: bool  # whether the latest recording of the pad that could be judged shows it
    shown: int  # in how many of the pad's recordings
    judged: int  # how many of them could be judged
    size: str = ""  # its parameters in the latest recording that shows it
    dated_by: str = "recording"  # or "file" where a date is only that of a file
    note: str = ""


def summarize_rows(examined: Sequence[tuple[Found, Row]]) -> list[Finding]:
    """Return the table, by hand and pad."""
    pads: dict[tuple[str, str], list[tuple[Found, Row]]] = defaultdict(list)
    for found, row in sorted(examined, key=lambda pair: (pair[0].date, pair[0].path)):
        pads[found.hand, found.pad].append((found, row))
    return [finding for pad in sorted(pads) for finding in _of_pad(pads[pad])]


def _of_pad(rows: list[tuple[Found, Row]]) -> list[Finding]:
    judged = [(found, row) for found, row in rows if row.verdict != FAILED]
    names = dict.fromkeys(name for _, row in judged for name in _shown(row))
    out = [_finding(name, judged) for name in names if name != NONE or len(names) == 1]
    for found, row in rows:
        if row.verdict == FAILED:
            out.append(
                Finding(found.hand, found.pad, FAILED, found.date, found.date, present=False, shown=0,
                        judged=len(judged), dated_by=found.dated_by, note=f"{found.path}: {row.note}")
            )  # fmt: skip
    return out


def _shown(row: Row) -> tuple[str, ...]:
    if row.verdict == "unexplained":
        return (*row.effects, UNEXPLAINED)
    return row.effects or (NONE,)


def _finding(name: str, judged: list[tuple[Found, Row]]) -> Finding:
    shows = [name in _shown(row) for _, row in judged]
    last = max(i for i, there in enumerate(shows) if there)
    first = shows.index(True)
    present = shows[-1]
    while present and first < last and not all(shows[first : last + 1]):
        first += 1 + shows[first + 1 :].index(True)
    found, row = judged[last]
    since = judged[first][0]
    by = "recording" if since.dated_by == found.dated_by == "recording" else "file"
    size = ", ".join(f"{symbol} {value:.3g}" for symbol, value in row.sizes.items()) if row.effects else ""
    return Finding(
        found.hand,
        found.pad,
        name,
        since.date,
        found.date,
        present,
        sum(shows),
        len(shows),
        size,
        by,
        "; ".join(text for text in (row.note, *row.doubts) if text),
    )


def csv_text(table: Sequence[Finding]) -> str:
    """Return the table as CSV."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [f.name for f in fields(Finding)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(one) for one in table)
    return stream.getvalue()
