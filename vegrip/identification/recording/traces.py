"""Whether there is a recording in a folder, and how to replace it; nothing else in the folder is touched."""

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from vegrip.errors import RecordingError
from vegrip.identification.recording.folder import CSV, TOML
from vegrip.identification.recording.writer import FILE_OF_MESSAGE, SESSION

MARKS: Final = (SESSION, TOML, CSV, f"{CSV}.gz")
OURS: Final = tuple(dict.fromkeys((*MARKS, *FILE_OF_MESSAGE.values())))


def holds_recording(folder: Path) -> bool:
    """Tell whether ``folder`` is a recording or a session, or what is left of one."""
    return any((folder / mark).is_file() for mark in MARKS)


@contextlib.contextmanager
def replaced(folder: Path) -> Iterator[None]:
    """Set the recording in ``folder`` aside while another is written, and put it back if that fails.

    Raises:
        RecordingError: a file cannot be moved.

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
