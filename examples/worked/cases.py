"""The recordings of the worked examples: what is fitted, what is held out, and what a user would type."""

import os
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
MAPS = HERE.parent / "maps"


@dataclass(frozen=True)
class Case:
    """One example.

    Attributes:
        name: of its table and picture.
        title: of the picture.
        column_map: file in examples/maps.
        train: tables to fit, relative to the data folder.
        heldout: tables that no fit sees.
        radius: of the probe; empty takes the map's.
        rows: expressions that the lines of both tables must match; empty takes all.
        options: of fit, refine and compare.
        shown: episodes of the fitted and of the held-out recording in the picture.
        unit: name and factor of the force in picture and table.
        most: effects that refine may add.
        add: effect that a user puts in by hand where refine adds nothing.
        backs_off: whether to tell how much of the fall after the peak the motion explains.
        scaled: whether held-out places are softer or firmer, so that each gets its own stiffness.

    """

    name: str
    title: str
    column_map: str
    train: tuple[str, ...]
    heldout: tuple[str, ...] = ()
    radius: str = ""
    rows: tuple[str, str] = ("", "")
    options: tuple[str, ...] = ()
    shown: tuple[int, int] = (0, 0)
    unit: tuple[str, float] = ("N", 1.0)
    most: int = 4
    add: str = ""
    scaled: bool = False
    backs_off: bool = False


def _silicone(*names: str) -> tuple[str, ...]:
    return tuple(f"silicone-indent/{name}.csv" for name in names)


CASES = (
    Case(
        "silicone-deep", "silicone, pressed to 17.75 mm", "silicone_hold",
        _silicone("relax_P002-laser-1"), _silicone("relax_P002-laser-3"),
        radius="40 mm", options=("--tolerance", "0.005"),
    ),
    Case(
        "silicone-six", "silicone, six presses fitted, six held out", "silicone_hold",
        _silicone("relax_P002-laser-1", "relax_P002-laser-2", "relax_P002-laser-5",
                  "recov_P002-3", "recov_P002-9", "recov_P002-11"),
        _silicone("relax_P002-laser-3", "relax_P002-laser-7", "recov_P002-4", "recov_P002-7",
                  "recov_P002-10", "recov_P002-12"),
        radius="40 mm", options=("--zeros-each-episode", "--tolerance", "0.01"), shown=(3, 2),
    ),
    Case(
        "meat", "meat, six places of a piece fitted, six of its other end held out", "meat",
        ("meat-indent/zwick_230331.csv",), ("meat-indent/zwick_230331.csv",), radius="20 mm",
        rows=("specimen|RDG1 1[A-F]", "specimen|RDG1 2[A-F]"),
        options=("--zeros-each-episode", "--tolerance", "0.01"), most=1, scaled=True,
    ),
    Case(
        "skin", "skin under a held force of 100, 400, 1000 mN; 800 mN held out", "skin",
        tuple(f"skin-force-hold/22-01-18_{force}mN.csv" for force in (100, 400, 1000)),
        ("skin-force-hold/22-01-18_800mN.csv",), radius="8 mm",
        options=("--zeros-each-episode", "--tolerance", "0.02"), shown=(1, 0), unit=("mN", 1e3),
    ),
    Case(
        "oocyte", "oocyte, runs 1, 4 and 7 fitted, 3, 10 and 13 held out", "afm_oocyte",
        tuple(f"afm-hold/oocyte_relax_00{run}.csv" for run in ("01", "04", "07")),
        tuple(f"afm-hold/oocyte_relax_00{run}.csv" for run in ("03", "10", "13")), radius="50 um",
        options=("--zeros-each-episode", "--tolerance", "0.01"), unit=("nN", 1e9),
    ),
    Case(
        "gel", "gel under a nano-indenter, sphere of 27.5 um", "afm_chiaro",
        ("afm-hold/chiaro_AEBP1_indent_002.csv",), options=("--tolerance", "0.01"), unit=("nN", 1e9),
        add="adhesion",
    ),
    Case(
        "robot-hand", "robot finger: 20 trials to 1.6 N fitted, 20 to 3.2 N held out", "rh56",
        ("robot-hand-rh56/middlefinger_hybrid_force250_20trials_20260303-185511.csv",),
        ("robot-hand-rh56/middlefinger_hybrid_force500_20trials_20260303-185150.csv",), radius="8 mm",
        rows=("Stage|approach|contact", "Stage|approach|contact"), options=("--tolerance", "0.02"),
        shown=(3, 3), add="sensor_lag", backs_off=True,
    ),
)  # fmt: skip


def data_folder(given: str = "") -> Path:
    """Return where the measured recordings are: given, VEGRIP_DATA, or beside the project."""
    return Path(given or os.environ.get("VEGRIP_DATA", HERE.parents[2] / "shared" / "data"))
