"""Real pushes: the right pressure distribution predicts them better than the smooth profile does."""

import importlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

EXAMPLE = Path(__file__).parents[3] / "examples" / "limit_surface_push"
THREE_FEET = ("hardboard_3pt_30_90", "hardboard_3pt_10_130", "plywood_3pt_30_90")


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    return importlib.import_module("pushes")


@pytest.mark.parametrize("name", THREE_FEET)
def test_three_feet_beat_the_smooth_profile(
    name: str, example: ModuleType, measured: Callable[[str], Path]
) -> None:
    pushes = example.read_pushes(measured("limit-surface-push"), name)
    support = example.SUPPORTS[name]
    feet = example.judge(example.Mapped(support), pushes, support.size)
    # any radius, from well inside the feet to far outside
    for radius in np.geomspace(0.7, 3.0, 8) * support.size:
        smooth = example.judge(example.Smooth(radius), pushes, support.size)
        assert feet.limit_scatter < smooth.limit_scatter
        assert feet.slip_angle < smooth.slip_angle
        assert feet.load_error < smooth.load_error


@pytest.mark.parametrize("name", THREE_FEET)
def test_block_turns_about_its_feet_more_often_than_a_smooth_profile_can(
    name: str, example: ModuleType, measured: Callable[[str], Path]
) -> None:
    pushes = example.read_pushes(measured("limit-surface-push"), name)
    support = example.SUPPORTS[name]

    def at_a_foot(slips: np.ndarray) -> int:
        centres = example.slip_centres(slips)
        distance = np.linalg.norm(centres[:, None] - support.positions, axis=2).min(axis=1)
        return int(np.sum(distance < example.NEAR * support.size))

    _, by_feet = example.Mapped(support).limit(pushes.loads)
    _, by_smooth = example.Smooth(1.6 * support.size).limit(pushes.loads)
    assert at_a_foot(pushes.slips) > 2 * at_a_foot(by_smooth)
    assert at_a_foot(by_feet) == pytest.approx(at_a_foot(pushes.slips), abs=5)


def test_full_face_presses_more_on_its_rim_than_evenly(
    example: ModuleType, measured: Callable[[str], Path]
) -> None:
    pushes = example.read_pushes(measured("limit-surface-push"), "hardboard_patch")
    even = example.SUPPORTS["hardboard_patch"]
    errors = [example.judge(example.Mapped(m), pushes, even.size) for m in (even, example.rim())]
    assert errors[1].limit_scatter < errors[0].limit_scatter
    assert errors[1].slip_angle < errors[0].slip_angle


def test_prediction_of_its_own_pushes_is_perfect(example: ModuleType) -> None:
    rng = np.random.default_rng(11)
    slips = rng.normal(size=(20, 3)) * [0.01, 0.01, 0.2]
    for surface in (example.Mapped(example.feet(0.03, 0.09)), example.Smooth(0.06)):
        loads = 4.2 * surface.load(slips, np.zeros_like(slips))
        errors = example.judge(surface, example.Pushes(loads, slips), 0.04)
        assert errors.friction == pytest.approx(4.2, rel=1e-4)
        assert errors.limit_scatter < 1e-4
        assert errors.slip_angle < 0.1
        assert errors.load_error < 1e-4


def test_example_ends_well_without_the_measurements(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, EXAMPLE / "run.py"],
        env={"VEGRIP_DATA": str(tmp_path / "nowhere"), "MPLCONFIGDIR": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 77, done.stderr
    assert "skipped" in done.stdout
