"""The whole fit, on recordings of a test bench that shares no physics with the model."""

import json

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.effects import effect
from vegrip.errors import RecordingError
from vegrip.identification.fit import fit
from vegrip.identification.recording import Fingertip, Recording, write_recording
from vegrip.model import paper_model, read_model
from vegrip.parameters import coordinate

pytestmark = pytest.mark.slow

TRUE = {"K": 1.8, "p": 1.5, "c1": 0.3, "nu1": 3.1, "mu": 0.8}


@pytest.fixture(scope="module")
def plain(bench):
    return fit(bench())


def test_parameters_come_back_within_their_standard_errors(plain) -> None:
    for name, true in TRUE.items():
        _, declared = plain.declared(name)
        off = coordinate(declared, plain.model.values[name].value) - coordinate(declared, true)
        assert abs(off) < 4.0 * plain.std[name] + 0.004, (
            name
        )  # patch elements are coarse, the bench has 1 ms steps


def test_what_is_left_is_noise(plain) -> None:
    assert plain.error == pytest.approx(1.0, abs=0.02)
    for name, one in plain.channels.items():
        assert one.ratio == pytest.approx(1.0, abs=max(0.03, 3.0 / (2.0 * one.rows) ** 0.5)), name
        assert one.coverage95 == pytest.approx(0.95, abs=max(0.03, 3.0 * (0.05 / one.rows) ** 0.5)), name
    assert plain.channels["normal_force"].whiteness_p > 1e-3
    assert not plain.warnings()


@pytest.mark.long
def test_standard_errors_are_those_of_repeated_recordings(bench) -> None:
    fits = [fit(bench(seed=seed)) for seed in range(1, 5)]
    for name in ("K", "p", "c1", "nu1", "mu"):
        values = [coordinate(f.declared(name)[1], f.model.values[name].value) for f in fits]
        ratio = np.std(values, ddof=1) / np.mean([f.std[name] for f in fits])
        assert 0.1 < ratio < 2.2, name  # of four recordings 99 % of such ratios lie in 0.2 .. 2


def test_start_far_off_ends_at_the_same_place(bench, plain) -> None:
    far = paper_model(0.01).with_value("K", 200.0).with_value("nu1", 0.1).with_value("p", 2.3)
    found = fit(bench(), far)
    for name in ("K", "p", "c1", "nu1"):
        assert found.model.values[name].value == pytest.approx(plain.model.values[name].value, rel=2e-3)


def test_outliers_hardly_move_the_fit(bench, plain) -> None:
    recording = bench()
    force = recording.columns["normal_force"].copy()
    force[np.random.default_rng(1).choice(force.size, 40, replace=False)] += 0.5
    wild = Recording("wild", recording.t, recording.episode, {**recording.columns, "normal_force": force},
                     recording.fingertip, recording.sensors)  # fmt: skip
    found = fit(wild)
    assert any("outlier" in sentence for sentence in found.warnings())
    for name in ("K", "p", "c1", "nu1"):
        assert found.model.values[name].value == pytest.approx(plain.model.values[name].value, rel=5e-3)


def test_a_value_without_spread_is_kept_and_what_the_data_do_not_tell_is_said(bench) -> None:
    recording = bench()
    columns = {name: recording.columns[name] for name in ("displacement", "normal_force")}
    bare = Recording("bare", recording.t, recording.episode, columns, Fingertip(0.01), recording.sensors)
    found = fit(bare, paper_model(0.01).with_value("p", 1.5, std=0.0))
    assert found.model.values["p"].value == 1.5
    told = " ".join(found.warnings())
    assert "mu (coulomb_friction) is not determined" in told
    assert "no row slides" in told
    assert "nu1" not in told


def test_a_value_on_its_bound_is_said(bench) -> None:
    found = fit(bench(), paper_model(0.01).with_value("nu1", 2.0, low=0.5, high=2.5))
    assert any("nu1 (relaxation) sits on its upper bound" in sentence for sentence in found.warnings())


def test_zeros_of_each_episode_are_found(bench) -> None:
    recording = bench()
    shift = 2e-5 * np.sin(recording.episode.astype(float))
    columns = {**recording.columns, "displacement": recording.columns["displacement"] + shift}
    moved = Recording(
        "moved", recording.t, recording.episode, columns, recording.fingertip, recording.sensors
    )
    one, each = fit(moved), fit(moved, zeros="episode")
    assert one.error > 1.3
    assert each.error == pytest.approx(1.0, abs=0.02)
    _, (zeros, _) = each.problem.parts(each.optimum.u)
    assert zeros - shift == pytest.approx(np.full(zeros.size, np.mean(zeros - shift)), abs=5e-6)


def test_an_effect_that_is_there_is_measured(bench) -> None:
    found = fit(bench("sensor_lag"), paper_model(0.01).with_effect(effect("sensor_lag")))
    assert found.model.values["tau"].value == pytest.approx(5e-3, rel=0.05)
    assert found.error == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("missing", ["displacement", "normal_force"])
def test_what_a_fit_needs_is_said(bench, missing) -> None:
    recording = bench()
    columns = {name: values for name, values in recording.columns.items() if name != missing}
    poor = Recording("poor", recording.t, recording.episode, columns, recording.fingertip, recording.sensors)
    with pytest.raises(RecordingError, match=missing):
        fit(poor)


def test_command_writes_a_model_that_reads_back(bench, plain, tmp_path, capsys) -> None:
    write_recording(bench(), tmp_path / "press")
    assert main(["fit", str(tmp_path / "press"), "-o", str(tmp_path / "m.toml"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    model = read_model(tmp_path / "m.toml")
    assert told["parameters"]["K"]["value"] == pytest.approx(model.values["K"].value)
    for symbol, scale in (("K", model.values["K"].value), ("p", 1.0)):  # in JSON a std is in the value's unit
        assert told["parameters"][symbol]["std"] == pytest.approx(scale * model.values[symbol].std)
    assert model.values["K"].value == pytest.approx(plain.model.values["K"].value, rel=1e-3)
    assert model.provenance["recording"] == "plain"


def test_command_refuses_what_is_no_recording(tmp_path, capsys) -> None:
    assert main(["fit", str(tmp_path / "nowhere")]) == 3
    assert "Traceback" not in capsys.readouterr().err


def test_a_grasp_without_air_is_told_to_determine_no_zero() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 4.0, 0.005)
    depth = 1.5e-3 + 1e-4 * np.sin(4.0 * t)
    before = np.interp(np.arange(-2.0, 0.0, 0.005), [-2.0, -1.0, -0.5, 0.0], [-1e-4, -1e-4, 1.5e-3, 1.5e-3])
    whole = paper_model(8e-3).simulate(np.arange(-2.0, 4.0, 0.005), np.r_[before, depth]).normal_force
    columns = {
        "displacement": depth + 5e-6 * rng.standard_normal(t.size),
        "normal_force": whole[-t.size :] + 0.01 * rng.standard_normal(t.size),
    }
    recording = Recording("grasp", t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(8e-3), {}, {})
    said = "the fingertip is never in the air"
    assert any(said in warning for warning in fit(recording).warnings())


def test_a_recording_with_air_is_not_told_so(plain) -> None:
    assert not any("never in the air" in warning for warning in plain.warnings())
