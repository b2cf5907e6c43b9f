"""The samples that ship are those that their maker makes, and every one of them can be used."""

import gzip
from importlib.resources import files
from pathlib import Path

import pytest

from tools import make_samples
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.fit.fitting import solve
from vegrip.identification.fit.result import rms
from vegrip.identification.recording import read_recording
from vegrip.identification.recording.can_log import read_can_log
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.data import join_recordings, select_episodes
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.samples import (
    LATER_TABLE,
    MODEL,
    MUSCLE,
    SAMPLE_LOG,
    SAMPLE_RADIUS_M,
    SAMPLE_TABLE,
    SAMPLES,
)
from vegrip.model import read_model


@pytest.mark.long
@pytest.mark.slow
def test_both_tables_are_made_anew_byte_by_byte() -> None:
    shipped = gzip.decompress(
        files("vegrip.identification.samples").joinpath(f"{SAMPLE_TABLE}.gz").read_bytes()
    )
    assert make_samples.table().encode() == shipped
    later = files("vegrip.identification.samples").joinpath(f"{LATER_TABLE}.gz").read_bytes()
    assert make_samples.table(is_later=True).encode() == gzip.decompress(later)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("samples")
    for name, sample in SAMPLES.items():
        sample.write(folder / name)
        assert sample.is_at(folder / name)
    return folder


def test_each_can_be_read_by_what_it_is_for(written: Path) -> None:
    press = read_recording(written / "press")
    assert not press.report.findings
    assert press.fingertip.radius == SAMPLE_RADIUS_M == read_model(written / MODEL).tip_radius
    log = read_can_log(written / SAMPLE_LOG, ("thumb",))["thumb"]
    assert log.report.rows_lost == 0
    assert log.columns["normal_force"].max() == pytest.approx(
        press.columns["normal_force"][press.t < make_samples.LOGGED].max(), abs=0.01
    )


@pytest.mark.long
def test_the_muscle_comes_with_its_licence_and_relaxes_by_a_power_law(written: Path, tmp_path: Path) -> None:
    folder = written / MUSCLE
    assert "MIT License" in (folder / "LICENSE").read_text(encoding="utf-8")
    assert sum(file.stat().st_size for file in folder.iterdir()) < 150_000
    chart = read_column_map(folder / "map.toml")
    tables = [folder / f"ramp-{time}s.csv" for time in ("0.1", "1", "100")]
    fibres = join_recordings([import_csv(path, chart) for path in tables], "fibres")
    found = diagnose(select_episodes(fibres, without="1"))  # the ramp of 1 s is not seen
    assert "power_law_relaxation" in found.named
    unseen = select_episodes(fibres, only="1")
    problem, best = solve(unseen, found.model, noise=None, zeros="recording", report=print, symbols=())
    force, _, _ = problem.raw(problem.table(best.u))
    assert rms(force) < 0.04 * unseen.columns["normal_force"].max()
