"""The measured recordings come in whole and in the right units: checked against their own descriptions."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vegrip.identification.recording import Recording
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.import_csv import import_csv

MAPS = Path(__file__).parents[3] / "examples" / "maps"
Measured = Callable[[str], Path]

SETS = [
    ("silicone-indent", "relax_*.csv", "silicone_hold"),
    ("silicone-indent", "recov_*.csv", "silicone_recovery"),
    ("skin-force-hold", "*.csv", "skin"),
    ("afm-hold", "oocyte_relax_*.csv", "afm_oocyte"),
    ("afm-hold", "chiaro_*.csv", "afm_chiaro"),
    ("afm-hold", "polymergel_*.csv", "afm_gel"),
    ("afm-hold", "force_distance_*.csv", "afm_force_distance"),
]


def imported(path: Path, chart: str) -> Recording:
    return import_csv(path, read_column_map(MAPS / f"{chart}.toml"))


@pytest.mark.parametrize(("folder", "pattern", "chart"), SETS)
def test_every_row_of_every_file_is_kept(folder: str, pattern: str, chart: str, measured: Measured) -> None:
    files = sorted(measured(folder).glob(pattern))
    assert files
    for path in files:
        recording = imported(path, chart)
        assert len(recording) == len(path.read_text().splitlines()) - 1
        assert recording.report.rows_lost == 0
        short = {"normal_force"} if chart == "afm_oocyte" else set()  # too few rows in the air tell no noise
        assert set(recording.sensors) == {"normal_force", "displacement"} - short


def test_silicone_is_in_newtons_and_metres(measured: Measured) -> None:
    deep = imported(measured("silicone-indent") / "relax_P002-laser-1.csv", "silicone_hold")
    assert deep.columns["normal_force"].max() == pytest.approx(4.96, abs=0.005)  # stopped at 4.96 N
    assert deep.columns["displacement"].max() == pytest.approx(17.75e-3, abs=1e-5)
    held = deep.columns["normal_force"][deep.t > 107.0]
    assert 1.0 - held[-1] / deep.columns["normal_force"].max() == pytest.approx(0.21, abs=0.005)
    assert math.isnan(deep.fingertip.radius)
    first = imported(measured("silicone-indent") / "recov_P002-1.csv", "silicone_recovery")
    assert first.columns["normal_force"].max() == pytest.approx(0.380, abs=5e-4)


@pytest.mark.parametrize(
    ("target", "mean", "creep"), [(100, 104.9, 0.114), (400, 403.6, 0.276), (800, 802.4, 0.356)]
)
def test_skin_is_in_newtons_and_metres(target: int, mean: float, creep: float, measured: Measured) -> None:
    path = measured("skin-force-hold") / f"22-01-18_{target}mN.csv"
    skin = imported(path, "skin")
    force, depth = skin.columns["normal_force"], skin.columns["displacement"]
    command = np.loadtxt(path, delimiter=",", skiprows=1, usecols=4)  # [mN]
    settled = np.flatnonzero(command == target)
    hold = settled[skin.t[settled] >= skin.t[settled[0]] + 0.02]
    assert force[hold].mean() * 1e3 == pytest.approx(mean, abs=0.5)
    assert (depth[hold[-1]] - depth[hold[0]]) * 1e3 == pytest.approx(creep, abs=0.01)
    assert depth[0] < 0.0  # in the air the lever is above the skin


def test_oocyte_force_starts_at_zero_and_relaxes_as_described(measured: Measured) -> None:
    run = imported(measured("afm-hold") / "oocyte_relax_0001.csv", "afm_oocyte")
    force = run.columns["normal_force"]
    hold = (run.t >= 2.0) & (run.t < 32.0)
    assert force.max() == pytest.approx(312e-9, abs=1e-9)
    assert force[hold][-1] == pytest.approx(104e-9, abs=1e-9)
    assert force.min() == pytest.approx(-126e-9, abs=1e-9)  # adhesion
    assert run.columns["displacement"][hold].mean() == pytest.approx(20e-6, rel=0.03)


def test_chiaro_knows_its_sphere(measured: Measured) -> None:
    press = imported(measured("afm-hold") / "chiaro_AEBP1_indent_002.csv", "afm_chiaro")
    assert press.fingertip.radius == 27.5e-6
    assert press.columns["normal_force"].max() == pytest.approx(0.049e-6, abs=0.5e-9)
    assert press.columns["normal_force"].min() == pytest.approx(-0.017e-6, abs=0.5e-9)
    assert press.columns["displacement"].max() == pytest.approx(
        12e-6, rel=0.1
    )  # instrument: 13 um, other zero


def test_tissue_is_three_relaxations_of_one_file_in_newtons_and_metres(measured: Measured) -> None:
    tissue = imported(measured("tissue-indent") / "Hayes_data.txt.gz", "mach1")
    stated = (0.2096, 0.5877, 0.3026), (0.2322, 0.7240, 0.2526), (0.1924, 0.3076, 0.1451)  # [mm], [gf]
    for number, (depth, peak, end) in enumerate(stated):
        rows = tissue.episode == number
        assert tissue.columns["displacement"][rows][-1] == pytest.approx(1e-3 * depth, abs=1e-6)
        force = tissue.columns["normal_force"][rows] / 9.80665e-3  # [gf]
        assert force[-1] == pytest.approx(end, abs=1e-3)
        assert force.max() == pytest.approx(peak, abs=1e-4)
        assert tissue.t[rows][-1] - tissue.t[rows][0] == pytest.approx(301.6, abs=0.2)
