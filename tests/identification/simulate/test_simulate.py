"""Simulated recordings: the model and nothing but the model, and what a fit makes of them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import UsageError
from vegrip.identification.fit import fit
from vegrip.identification.recording import read_recording
from vegrip.identification.simulate import DEFAULT_NOISE, Protocol, Segment, like, simulate, write_protocol
from vegrip.identification.simulate.protocol import standard
from vegrip.model import paper_model, write_model

MODEL = paper_model(8e-3).with_value("nu1", 4.0).with_value("mu", 0.6)
EXACT = dict.fromkeys(DEFAULT_NOISE, 0.0)
PRESS = Protocol("press", ((Segment(0.2, depth=-1e-4), Segment(0.2, depth=8e-4), Segment(2.0)),), 0.0)


@pytest.fixture(scope="module")
def made():
    return simulate(
        MODEL, standard(MODEL), seed=4, rate=100.0, sensors={**DEFAULT_NOISE, "contact_radius": 5e-5}
    )


def test_without_noise_the_force_is_that_of_the_model() -> None:
    found = simulate(MODEL, PRESS, sensors=EXACT)
    fine = np.arange(1, 2401) * 1e-3
    depth = np.interp(fine, [0.0, 0.2, 0.4, 2.4], [0.0, -1e-4, 8e-4, 8e-4])
    force = MODEL.simulate(np.r_[0.0, fine], np.r_[0.0, depth]).sensed_force[1:]
    assert found.t == pytest.approx(fine[4::5])
    assert found.columns["displacement"] == pytest.approx(depth[4::5])
    assert found.columns["normal_force"] == pytest.approx(force[4::5], abs=1e-9)


def test_a_force_that_is_imposed_is_reached_and_held_while_the_contact_creeps() -> None:
    hold = (Segment(0.2, depth=2e-4), Segment(0.2, force=1.0), Segment(1.0), Segment(0.5, depth=-1e-4))
    found = simulate(MODEL, Protocol("creep", (hold, hold), 1.0), sensors=EXACT, rate=1000.0)
    for number in (0, 1):
        t, force, depth = (
            v[found.episode == number]
            for v in (found.t, *map(found.columns.get, ("normal_force", "displacement")))
        )
        t = t - t[0]
        held = (t > 0.4) & (t < 1.398)
        assert force[held] == pytest.approx(1.0, abs=1e-6)
        assert np.all(np.diff(depth[held]) > 0.0)
        assert depth[-1] == pytest.approx(-1e-4)
        assert np.abs(np.diff(depth)).max() < 1.2e-5  # no jump where the axis changes over


def test_a_pull_rises_and_then_slides_at_the_limit() -> None:
    pull = (Segment(0.2, depth=5e-4), Segment(1.0), Segment(1.0, pull_x=2e-3), Segment(0.5))
    found = simulate(MODEL, Protocol("pull", (pull,), 0.0), sensors=EXACT)
    force, normal = found.columns["tangential_force_x"], found.columns["normal_force"]
    slides = found.columns["slip"] == 1.0
    assert force[slides] == pytest.approx(0.6 * normal[slides], rel=1e-3)
    assert np.all(force <= 0.6 * normal * (1.0 + 1e-3))
    assert found.t[slides].min() == pytest.approx(1.2 + 0.6 * 5e-4 / 2e-3, abs=0.02)
    assert found.t[slides].max() <= 2.2 + 1e-9
    assert found.columns["slip_speed"][slides] == pytest.approx(2e-3)
    assert np.all(found.columns["slip_speed"][~slides] == 0.0)


def test_a_twist_slides_at_the_torsional_limit() -> None:
    twist = (Segment(0.2, depth=5e-4), Segment(1.0, spin=1.5))
    sensors = {**EXACT, "contact_radius": 0.0}
    found = simulate(MODEL, Protocol("twist", (twist,), 0.0), sensors=sensors)
    slides = found.columns["slip"] == 1.0
    N, a, m = (found.columns[name][slides] for name in ("normal_force", "contact_radius", "torque_z"))
    assert slides.any()
    assert m == pytest.approx(3.0 * np.pi / 16.0 * 0.6 * N * a, rel=0.02)  # k stays near 2: PHYSICS 1.3


def test_fit_gives_back_what_was_simulated(made) -> None:
    found = fit(made)
    assert found.error == pytest.approx(1.0, abs=0.03)
    for symbol in ("K", "p", "c1", "nu1", "mu"):
        truth, std = MODEL.values[symbol].value, found.std[symbol]
        log = MODEL.parameters[symbol][1].transform == "log"
        off = (
            np.log(found.model.values[symbol].value / truth)
            if log
            else found.model.values[symbol].value - truth
        )
        assert abs(off) < 4.0 * std


def test_the_same_seed_gives_the_same_recording_and_another_one_other_noise(made) -> None:
    again = simulate(
        MODEL, standard(MODEL), seed=4, rate=100.0, sensors={**DEFAULT_NOISE, "contact_radius": 5e-5}
    )
    other = simulate(MODEL, PRESS, seed=5)
    assert all(np.array_equal(again.columns[name], made.columns[name]) for name in made.columns)
    assert not np.array_equal(
        other.columns["normal_force"], simulate(MODEL, PRESS, seed=6).columns["normal_force"]
    )


def test_noise_is_as_large_as_stated() -> None:
    long = Protocol("air", ((Segment(50.0, depth=-1e-3),),), 0.0)
    found = simulate(MODEL, long, sensors={"normal_force": 0.02, "displacement": 0.0, "torque_z": 1e-3})
    assert np.std(found.columns["normal_force"]) == pytest.approx(0.02, rel=0.03)
    assert np.std(found.columns["torque_z"]) == pytest.approx(1e-3, rel=0.03)
    assert "tangential_force_x" not in found.columns
    assert dict(found.sensors) == {"normal_force": 0.02, "torque_z": 1e-3}


def test_like_a_recording_the_model_is_what_a_fit_of_it_finds(made) -> None:
    other = MODEL.with_value("K", 1.3 * MODEL.values["K"].value).with_value("mu", 0.8)
    found = like(other, made, seed=1)
    assert found.columns.keys() == made.columns.keys()
    assert np.array_equal(found.t, made.t)
    refit = fit(found)
    assert refit.error == pytest.approx(1.0, abs=0.03)
    assert refit.model.values["K"].value == pytest.approx(other.values["K"].value, rel=0.02)
    assert refit.model.values["mu"].value == pytest.approx(0.8, rel=0.02)


def test_like_keeps_holes(made) -> None:
    columns = dict(made.columns)
    columns["normal_force"] = columns["normal_force"].copy()
    columns["normal_force"][100:120] = np.nan
    found = like(MODEL, replace(made, columns=columns))
    assert np.isnan(found.columns["normal_force"]).nonzero()[0].tolist() == list(range(100, 120))


def test_sensors_that_are_none_are_refused() -> None:
    with pytest.raises(UsageError, match="no sensor force"):
        simulate(MODEL, PRESS, sensors={**DEFAULT_NOISE, "force": 0.1})
    with pytest.raises(UsageError, match="need normal_force"):
        simulate(MODEL, PRESS, sensors={"normal_force": 0.1})


def test_the_command_writes_a_recording_that_reads_back(tmp_path, capsys) -> None:
    write_model(MODEL, tmp_path / "m.toml")
    write_protocol(PRESS, tmp_path / "p.toml")
    model, folder = str(tmp_path / "m.toml"), str(tmp_path / "rec")
    given = [
        "--protocol",
        str(tmp_path / "p.toml"),
        "--noise",
        "contact_radius=5e-5",
        "--plot",
        str(tmp_path / "p.png"),
    ]
    assert main(["simulate", model, "-o", folder, *given, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"] == 480
    assert set(told["columns"]) == set(read_recording(folder).columns)
    assert told["name"] == "rec"  # as what is fitted to it is called in all that is printed
    assert (tmp_path / "p.png").stat().st_size > 5000
    assert (
        main(["simulate", model, "-o", str(tmp_path / "again"), "--like", folder, "--with", "adhesion"]) == 0
    )
    assert "adhesion" in read_recording(tmp_path / "again").source["model"]
    capsys.readouterr()
    for wrong, code in (
        (["--noise", "normal_force=much"], 2),
        (["--noise", "normal_force=-1"], 2),
        (["--protocol", "absent.toml"], 3),
        (["--with", "magic"], 3),
        (["--with", "relaxation"], 2),
        (["--like", folder, "--noise", "torque_z=1"], 2),
        (["--like", "absent"], 3),
    ):
        assert main(["simulate", model, "-o", folder, *wrong]) == code
        assert "Traceback" not in capsys.readouterr().err
