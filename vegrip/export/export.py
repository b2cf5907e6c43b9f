"""From a model to a folder of C."""

from dataclasses import dataclass
from pathlib import Path

from vegrip.export import texts
from vegrip.export.measure import Measured, measure
from vegrip.export.precision import PRECISIONS
from vegrip.export.report import report
from vegrip.export.request import Request
from vegrip.whole_file import write_whole


@dataclass(frozen=True)
class Exported:
    """The files that were written, and what was measured of them."""

    files: tuple[Path, ...]
    ram: int  # [bytes] of a finger
    measured: Measured


def write_export(request: Request, folder: Path) -> Exported:
    """Write what is asked for as C99 to ``folder``, compile it, run its self-test and report.

    Raises:
        UntranslatableError: a line of an effect or kernel has no counterpart in C; names file and line.
        OSError: a file cannot be written.

    """
    written = texts.write(request)
    paths = []
    for name, text in written.files.items():
        paths.append(_write(folder / name, text))
    precision = PRECISIONS[request.precision]
    measured = measure(folder, request.prefix, written.program.calls, request.entry, precision)
    paths.append(_write(folder / "REPORT.md", report(request, written, measured)))
    return Exported(tuple(paths), written.ram, measured)


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text)
    return path
