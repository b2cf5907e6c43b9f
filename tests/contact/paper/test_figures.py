"""Every figure is drawn, and what it shows obeys the law it shows."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need the extra 'plot'")

from matplotlib.axes import Axes

from vegrip.cli import main
from vegrip.contact.paper.figures import FIGURES


def curves(ax: Axes) -> list[tuple[np.ndarray, np.ndarray]]:
    lines = [line for line in ax.get_lines() if not str(line.get_label()).startswith("_")]
    return [(np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)) for line in lines]


def carried(r: np.ndarray, p: np.ndarray) -> float:
    """Force under a plotted pressure over its mean area pi: ``int p r dr`` of both halves."""
    return float(np.trapezoid(p * np.abs(r), r))


@pytest.mark.long
def test_every_figure_is_written_as_png(tmp_path: Path) -> None:
    assert main(["paper", "-o", str(tmp_path / "new" / "figures")]) == 0
    files = sorted((tmp_path / "new" / "figures").iterdir())
    assert [file.stem for file in files] == sorted(FIGURES)
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in files)


def test_a_folder_that_cannot_be_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    assert main(["paper", "-o", str(tmp_path / "file" / "figures")]) == 3
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_says_what_it_shows(name: str) -> None:
    for ax in FIGURES[name]().axes:
        assert ax.get_xlabel()
        assert ax.get_ylabel()
        assert "t" not in ax.get_xlabel() or "[s]" in ax.get_xlabel() or "f_t" in ax.get_xlabel()


@pytest.mark.parametrize(("name", "panel"), [("fig02", 0), ("fig05", 0), ("fig08", 0)])
def test_pressures_under_constant_load_carry_the_same_force(name: str, panel: int) -> None:
    shown = curves(FIGURES[name]().axes[panel])
    assert len(shown) >= 5
    for r, p in shown:
        assert carried(r, p) == pytest.approx(1, abs=5e-3)


def test_pressures_at_constant_displacement_fade_with_the_force() -> None:
    left, right = FIGURES["fig04"]().axes
    t, N = left.get_lines()[0].get_data()
    forces = [carried(r, p) for r, p in curves(right)]
    assert forces[0] == pytest.approx(1, abs=5e-3)
    assert forces == pytest.approx(
        0.7 + 0.3 * np.exp(-3.1 * np.array([0.0, 0.1, 0.2, 0.5, 1.0, np.inf])), abs=5e-3
    )
    assert np.interp(0.5, t, N) == pytest.approx(forces[3], abs=5e-3)


def test_limit_surfaces_shrink_in_proportion_at_constant_area() -> None:
    shown = curves(FIGURES["fig09"]().axes[0])
    f0, m0 = shown[0]
    for f, m in shown[1:]:
        scale = m[0] / m0[0]
        assert scale < 1
        assert f == pytest.approx(scale * f0, abs=1e-12)
        assert m == pytest.approx(scale * m0, abs=1e-12)


def test_limit_surfaces_grow_at_constant_load_but_for_pure_force() -> None:
    shown = curves(FIGURES["fig10"]().axes[0])
    for (f0, m0), (f1, m1) in pairwise(shown):
        moment_at_same_force = np.interp(f0[:-1], f1, m1)
        assert np.all(moment_at_same_force[f0[:-1] < 0.99] > m0[:-1][f0[:-1] < 0.99])
        assert f1[-1] == pytest.approx(f0[-1], abs=1e-5)


def test_profiles_end_at_the_edge_of_the_patch() -> None:
    for r, p in curves(FIGURES["fig02"]().axes[0]):
        assert (r[0], r[-1]) == (-1.0, 1.0)
        assert p[0] == p[-1] == 0.0
