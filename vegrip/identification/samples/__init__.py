"""Sample files that ship with the package, so that every example of the help runs as written.

One fingertip of 8 mm radius, pressed, held, and pulled until it slips, on the virtual bench (which shares no
physics code with the model), with adhesion hidden in it. :mod:`tools.make_samples` made them. And muscle
fibres, measured by others, with their licence.
"""

import contextlib
import gzip
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Final

from vegrip.errors import InputError, UsageError, suggestion
from vegrip.whole_file import filled_folder, whole_file, write_whole

if TYPE_CHECKING:
    from vegrip.identification.recording import Recording

SAMPLE_RADIUS_M: Final = 8e-3  # [m]
COLUMNS: Final = (
    "t=time_s",
    "episode=trial",
    "displacement=depth_mm",
    "normal_force=force_mN",
    "tangential_force_x=pull_x_mN",
    "tangential_force_y=pull_y_mN",
    "torque_z=turn_mNm",
    "slip=sliding",
    "slip_speed=slip_mm_s",
)
UNITS: Final = (
    "displacement=mm",
    "normal_force=mN",
    "tangential_force_x=mN",
    "tangential_force_y=mN",
    "torque_z=mN*m",
    "slip_speed=mm/s",
)
NOISE: Final = {
    "displacement": 5e-6,
    "normal_force": 0.01,
    "tangential_force_x": 0.01,
    "torque_z": 1e-4,
}  # SI
SAMPLE_TABLE: Final = "press.csv"
LATER: Final = "press-later"
LATER_TABLE: Final = f"{LATER}.csv"
SAMPLE_LOG: Final = "press.blf"
MODEL: Final = "press.toml"
HIDDEN_LAW: Final = "tiring.py"
MUSCLE: Final = "muscle"
LIFT: Final = "lift"
FOREIGN_DATABASE: Final = "foreign.dbc"
FOREIGN_LOG: Final = "foreign.blf"


@dataclass(frozen=True)
class Sample:
    """One sample: what it is, and what writes it to a path."""

    about: str
    write: Callable[[Path], object]

    def is_at(self, path: Path) -> bool:
        """Return whether ``path`` is this sample already, unchanged."""
        with tempfile.TemporaryDirectory() as scratch:
            fresh = Path(scratch) / path.name
            self.write(fresh)
            return bool(_content(fresh)) and _content(path) == _content(fresh)


def _content(path: Path) -> list[bytes]:
    files = sorted(path.iterdir()) if path.is_dir() else [path] if path.is_file() else []
    return [file.read_bytes() for file in files if file.is_file()]


def recording(table: str = SAMPLE_TABLE) -> "Recording":
    """Return the sample recording that ships as ``table``."""
    from vegrip.identification.recording.column_map import ColumnMap, with_columns  # noqa: PLC0415 (heavy)
    from vegrip.identification.recording.import_csv import import_csv  # noqa: PLC0415

    chart = with_columns(ColumnMap(), COLUMNS, UNITS)
    channels = {name: replace(entry, noise=NOISE.get(name, 0.0)) for name, entry in chart.channels.items()}
    with as_file(files(__name__).joinpath(f"{table}.gz")) as path:
        return import_csv(path, replace(chart, channels=channels), radius=SAMPLE_RADIUS_M)


def _write_table(path: Path) -> None:
    write_whole(path, gzip.decompress(files(__name__).joinpath(f"{SAMPLE_TABLE}.gz").read_bytes()))


def _write_muscle(folder: Path) -> None:
    with filled_folder(folder), contextlib.ExitStack() as parts:
        for file in files(__name__).joinpath(MUSCLE).iterdir():
            parts.enter_context(whole_file(folder / file.name)).write_bytes(file.read_bytes())


def _copied(name: str) -> Callable[[Path], object]:
    return lambda path: write_whole(path, files(__name__).joinpath(name).read_bytes())


def _write_model(path: Path) -> None:
    from vegrip.model import paper_model, write_model  # noqa: PLC0415 (heavy, and the others do without)

    write_model(paper_model(SAMPLE_RADIUS_M), path)


def _write_lift(folder: Path) -> None:
    from vegrip.identification.samples.lift import write_lift  # noqa: PLC0415 (heavy)

    with filled_folder(folder):
        write_lift(folder)


def _recorded(table: str) -> Callable[[Path], object]:
    def write(path: Path) -> None:
        from vegrip.identification.recording import write_recording  # noqa: PLC0415 (heavy)

        write_recording(recording(table), path)

    return write


SAMPLES: Final = {
    "press": Sample(
        "a recording: a fingertip pressed, held and pulled until it slips", _recorded(SAMPLE_TABLE)
    ),
    LATER: Sample("the same fingertip later, somewhat changed, for `vegrip changed`", _recorded(LATER_TABLE)),
    SAMPLE_TABLE: Sample(
        "the same as the table of a test rig, in mm and mN, for `vegrip import`", _write_table
    ),
    SAMPLE_LOG: Sample(
        "its first seconds as a CAN log of the finger thumb, for `vegrip import`", _copied(SAMPLE_LOG)
    ),
    FOREIGN_DATABASE: Sample(
        "the database of a gripper of another make, for `vegrip connect`", _copied(FOREIGN_DATABASE)
    ),
    FOREIGN_LOG: Sample("ten seconds of it: rest, press, shear, twist of its left tip", _copied(FOREIGN_LOG)),
    HIDDEN_LAW: Sample(
        "an effect that no catalogue has, for `vegrip simulate --with` and `vegrip draft`",
        _copied(HIDDEN_LAW),
    ),
    MUSCLE: Sample(
        "measured: muscle fibres stretched at three speeds and held, with a map for `vegrip import`",
        _write_muscle,
    ),
    LIFT: Sample(
        "a session: two fingers lift 0.5 kg three times, for `vegrip calibrate --weight`", _write_lift
    ),
    MODEL: Sample("a model of that fingertip before any fit, for `vegrip simulate`", _write_model),
}


def sample(name: str, path: Path | str = "") -> Path:
    """Write a sample that ships with vegrip to ``path``, under its own name where none is given.

    Raises:
        UsageError: there is no such sample; names those that there are.
        InputError: something else is there already.

    """
    if name not in SAMPLES:
        raise UsageError(f"there is no sample {name!r}; {suggestion(name, SAMPLES)}")
    place = Path(path or name)
    if not place.exists():
        SAMPLES[name].write(place)
    elif not SAMPLES[name].is_at(place):
        raise InputError(f"{place}: is there already, and is not this sample; give another path")
    return place
