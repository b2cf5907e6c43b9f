"""What a check has found so far: the ladder of models, and which of them is looked at; kept in a folder."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from vegrip.errors import InputError, UsageError
from vegrip.whole_file import write_whole

CHECK_FILE = "check.json"
VERSION = 1


@dataclass
class Rung:
    """One model, and what is known of it."""

    model: str  # file name in the folder
    effect: str | None  # that was added, None for the start
    parent: int | None  # rung it was added to
    error: float
    comparison: dict[str, Any] | None = None
    diagnosis: dict[str, Any] | None = None
    parameters: dict[str, Any] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    held_back: str = ""  # episodes that were left out of the fit, as in "2,5..7"
    held_out: dict[str, Any] | None = None  # comparison with them alone
    experiment: dict[str, Any] | None = None  # the next one that was asked for
    draft: dict[str, Any] | None = None  # of a law for what is left

    @property
    def held_error(self) -> float | None:
        return None if self.held_out is None else self.held_out["error"]

    @property
    def is_refit(self) -> bool:
        return self.effect is None and self.parent is not None


@dataclass
class Session:
    """All rungs and the one that is looked at."""

    recording: str
    rungs: list[Rung] = field(default_factory=list)
    current: int = 0

    @property
    def rung(self) -> Rung | None:
        return self.rungs[self.current] if self.rungs else None

    @property
    def path(self) -> list[Rung]:
        """The rungs from the start to the one that is looked at."""
        found: list[Rung] = []
        at: int | None = self.current if self.rungs else None
        while at is not None:
            found.append(self.rungs[at])
            at = self.rungs[at].parent
        return found[::-1]

    @property
    def effects(self) -> list[str]:
        return [rung.effect for rung in self.path if rung.effect is not None]

    def next_file(self, effect: str | None) -> str:
        return f"{len(self.rungs)}-{effect or ('refit' if self.rungs else 'start')}.toml"

    def add(self, rung: Rung) -> None:
        self.rungs.append(rung)
        self.current = len(self.rungs) - 1

    def undo(self) -> None:
        """Look at the model before the last effect; the one with it is kept."""
        rung = self.rung
        if rung is None or rung.parent is None:
            raise UsageError("this is the model that the check began with; there is no step to undo")
        self.current = rung.parent


def save(session: Session, folder: Path) -> None:
    """Write the session; a reader sees the old one or the new one."""
    write_whole(folder / CHECK_FILE, json.dumps({"version": VERSION, **asdict(session)}))


def load(folder: Path, recording: str) -> Session | None:
    """Read the session in ``folder``, None where there is none.

    Raises:
        InputError: it is of another recording, or cannot be read.

    """
    file = folder / CHECK_FILE
    if not file.is_file():
        return None
    try:
        saved = json.loads(file.read_text(encoding="utf-8"))
        found = Session(
            saved["recording"],
            [Rung(**rung) for rung in saved["rungs"]],
            min(saved["current"], len(saved["rungs"])),
        )
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise InputError(
            f"{file} cannot be read ({error}); move the folder away, or give another with -o"
        ) from None
    if found.recording != recording:
        raise InputError(f"{folder} is the check of {found.recording}; give another folder with -o")
    return found
