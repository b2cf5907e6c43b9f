"""The recordings of the worked examples: what is fitted, what is held out, and what a user would type."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).parents[2]
MAPS = PROJECT / "examples/maps"


@dataclass(frozen=True)
class Case:
    """One example.

    Attributes:
        name: of its table and picture.
        title: of the picture.
        column_map: file in examples/maps; empty for unit steps of a material, which need none.
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
        source: repository and commit.
        licence: of the recordings.
        episodes: of the tables, that are fitted and held out; empty takes all.
        known: what a publication, a header or the maker says is there.
        beside: channel of which only the tables' names state the value, as a pattern's first group.

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
    source: str = ""
    licence: str = ""
    episodes: tuple[str, str] = ("", "")
    known: str = ""
    beside: tuple[str, str] = ("", "")


def _silicone(*names: str) -> tuple[str, ...]:
    return tuple(f"silicone-indent/{name}.csv" for name in names)


ZWICK = "SarahIaquinta/perineal_indentation 167a964"
CASES = (
    Case(
        "silicone-deep", "silicone, pressed to 17.75 mm", "silicone_hold",
        _silicone("relax_P002-laser-1"), _silicone("relax_P002-laser-3"),
        radius="40 mm", options=("--tolerance", "0.005"),
        source=ZWICK, licence="GPL-3",
        known="stiffens with depth; one relaxation time is not enough (README); one slip",
    ),
    Case(
        "silicone-six", "silicone, six presses fitted, six held out", "silicone_hold",
        _silicone("relax_P002-laser-1", "relax_P002-laser-2", "relax_P002-laser-5",
                  "recov_P002-3", "recov_P002-9", "recov_P002-11"),
        _silicone("relax_P002-laser-3", "relax_P002-laser-7", "recov_P002-4", "recov_P002-7",
                  "recov_P002-10", "recov_P002-12"),
        radius="40 mm", options=("--zeros-each-episode", "--tolerance", "0.01"), shown=(3, 2),
        source=ZWICK, licence="GPL-3",
        known="the same, and a recovery, a first touch and presses on the same spot",
    ),
    Case(
        "meat", "meat, six places of a piece fitted, six of its other end held out", "meat",
        ("meat-indent/zwick_230331.csv",), ("meat-indent/zwick_230331.csv",), radius="20 mm",
        rows=("specimen|RDG1 1[A-F]", "specimen|RDG1 2[A-F]"),
        options=("--zeros-each-episode", "--tolerance", "0.01"), most=1, scaled=True,
        source=ZWICK, licence="GPL-3",
        known="many relaxation times, strain hardening; places differ",
    ),
    Case(
        "skin", "skin under a held force of 100, 400, 1000 mN; 800 mN held out", "skin",
        tuple(f"skin-force-hold/22-01-18_{force}mN.csv" for force in (100, 400, 1000)),
        ("skin-force-hold/22-01-18_800mN.csv",), radius="8 mm",
        options=("--zeros-each-episode", "--tolerance", "0.02"), shown=(1, 0), unit=("mN", 1e3),
        source="SDAMcIntyre/Indentation_Discrimination da51ad7", licence="MIT",
        known="creep grows less than the force: stiffens; the lever rings in the air",
    ),
    Case(
        "oocyte", "oocyte, runs 1, 4 and 7 fitted, 3, 10 and 13 held out", "afm_oocyte",
        tuple(f"afm-hold/oocyte_relax_00{run}.csv" for run in ("01", "04", "07")),
        tuple(f"afm-hold/oocyte_relax_00{run}.csv" for run in ("03", "10", "13")), radius="50 um",
        options=("--zeros-each-episode", "--tolerance", "0.01"), unit=("nN", 1e9),
        source="AFM-analysis/afmformats 0.18.7", licence="MIT",
        known="two relaxation times (the package fits two), adhesion; the zero drifts from run to run",
    ),
    Case(
        "gel", "gel under a nano-indenter, sphere of 27.5 um", "afm_chiaro",
        ("afm-hold/chiaro_AEBP1_indent_002.csv",), options=("--tolerance", "0.01"), unit=("nN", 1e9),
        add="adhesion",
        source="AFM-analysis/afmformats 0.18.7", licence="MIT",
        known="adhesion: it pulls with a third of the peak",
    ),
    Case(
        "robot-hand", "robot finger: 20 trials to 1.6 N fitted, 20 to 3.2 N held out", "rh56",
        ("robot-hand-rh56/middlefinger_hybrid_force250_20trials_20260303-185511.csv",),
        ("robot-hand-rh56/middlefinger_hybrid_force500_20trials_20260303-185150.csv",), radius="8 mm",
        rows=("Stage|approach|contact", "Stage|approach|contact"), options=("--tolerance", "0.02"),
        shown=(3, 3), add="sensor_lag", backs_off=True,
        source="correlllab/rh56_controller e4ef256", licence="Apache-2.0",
        known="the actuator backs off: no relaxation",
    ),
)  # fmt: skip


def _muscle(*names: str) -> tuple[str, ...]:
    return tuple(f"muscle-stretch/{name}s.csv" for name in names)


RHEOJAX = "imewei/rheojax b79e79e, from the examples of pyRheo"
PYRHEO = "MIT the repository, none stated of the tables"
RELAXATION = "rheojax/examples/data/relaxation"
FISH = f"{RELAXATION}/biological/stressrelaxation_fishmuscle_data.csv"
STEP = ("--tolerance", "0.01")
MUSCLE = "../../vegrip/identification/samples/muscle/map"
TITIN = "beards-lab/TitinViscoelasticity 6cdda21"
# those of no worked example
FURTHER = (
    Case(
        "muscle", "muscle fibres stretched in 0.1 and 100 s fitted, in 1 s held out", MUSCLE,
        _muscle("AvgRelaxed_0.1", "AvgRelaxed_100"), _muscle("AvgRelaxed_1"), unit=("kPa", 1e3),
        source=TITIN, licence="MIT",
        known="power law over decades (the authors fit it); the peak falls with the time of the ramp",
    ),
    Case(
        "muscle-mavacamten", "the same with mavacamten", MUSCLE,
        _muscle("AvgRelaxedMavaSet_0.1", "AvgRelaxedMavaSet_100"), _muscle("AvgRelaxedMavaSet_1"),
        unit=("kPa", 1e3), source=TITIN, licence="MIT", known="the same",
    ),
    Case(
        "tissue", "tissue, two places fitted, a third held out", "mach1",
        ("tissue-indent/Hayes_data.txt.gz",), ("tissue-indent/Hayes_data.txt.gz",), radius="1 mm",
        options=("--zeros-each-episode", "--tolerance", "0.01"), unit=("mN", 1e3), scaled=True,
        source="RenatoC322/Biomomentum-functions ed1b31a", licence="MIT", episodes=("0,1", "2"),
        known="the force is 16 ms late: a filter of order 3 at 20 Hz, stated in the file",
    ),
    Case(
        "laponite", "laponite aged 10, 30 and 60 minutes fitted, 20 and 40 minutes held out", "",
        tuple(f"{RELAXATION}/clays/rel_lapo_{age}.csv" for age in (600, 1800, 3600)),
        tuple(f"{RELAXATION}/clays/rel_lapo_{age}.csv" for age in (1200, 2400)),
        options=STEP, beside=("age", r"lapo_(\d+)"), source=RHEOJAX, licence=PYRHEO,
        known="a clay that ages: firmer and slower with its age",
    ),
    Case(
        "fish", "fish muscle, a stretch held: 100 s fitted, 100 to 981 s held out", "",
        (FISH,), (FISH,), rows=(r"^Time|^\d\d?\.", r"^Time|^\d{3}\."), options=STEP,
        source=RHEOJAX, licence=PYRHEO, known="a power law over decades (fractional models are fitted to it)",
    ),
    Case(
        "polystyrene", "polystyrene at 145, 160 and 190 degC fitted, at 175 degC held out", "",
        tuple(f"{RELAXATION}/polymers/stressrelaxation_ps{T}_data.csv" for T in (145, 160, 190)),
        (f"{RELAXATION}/polymers/stressrelaxation_ps175_data.csv",), options=STEP,
        beside=("temperature", r"ps(\d+)_"), source=RHEOJAX, licence=PYRHEO,
        known="a melt: flows at last; time and temperature shift alike",
    ),
    Case(
        "polystyrene-creep", "polystyrene at 160 degC, relaxation fitted, creep held out", "",
        (f"{RELAXATION}/polymers/stressrelaxation_ps160_data.csv",),
        ("rheojax/examples/data/creep/polymers/creep_ps160_data.csv",), options=STEP,
        source=RHEOJAX, licence=PYRHEO, known="one material: relaxation and creep agree",
    ),
)  # fmt: skip


def data_folder(given: str = "") -> Path:
    """Return where the measured recordings are: given, VEGRIP_DATA, or beside the project."""
    return Path(given or os.environ.get("VEGRIP_DATA", PROJECT.parent / "shared" / "data"))


def tables(case: Case, data: Path, folder: Path, which: int) -> list[Path]:
    """Return the tables of a case; where only some rows count, or a column is missing, copies of them."""
    names, pattern, (channel, stated) = (case.train, case.heldout)[which], case.rows[which], case.beside
    if not (pattern or channel):
        return [data / name for name in names]
    folder.mkdir(exist_ok=True)
    for name in names:
        lines = (data / name).read_text(encoding="utf-8").splitlines()
        if value := channel and re.search(stated, name):
            lines = [f"{line}\t{value[1] if i else channel}" for i, line in enumerate(lines)]
        kept = [f"{line}\n" for line in lines if re.search(pattern, line)]
        (folder / Path(name).name).write_text("".join(kept), encoding="utf-8")
    return [folder / Path(name).name for name in names]
