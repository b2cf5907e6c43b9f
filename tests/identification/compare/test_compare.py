"""Where a model fails, on recordings whose hidden effect is known."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.compare import compare
from vegrip.identification.compare.comparison import Comparison
from vegrip.identification.compare.where import (
    PHASES,
    Features,
    Residuals,
    format_quantity,
    format_span,
    where,
)
from vegrip.identification.fit import fit
from vegrip.identification.recording import Fingertip, Recording, write_recording
from vegrip.model import write_model

RNG = np.random.default_rng(0)
N = 9000


def features(phase=None, **values) -> Features:
    phase = np.full(N, PHASES.index("hold")) if phase is None else phase
    return Features(phase, values, np.zeros(N, dtype=bool))


def replicates(common: float, own: float) -> Comparison:
    """Two episodes of one motion; of the misfit the std ``common`` is the same in both, ``own`` is not."""
    n = 4000
    depth = np.tile(np.linspace(0.0, 1e-3, n), 2)
    episode, t = np.repeat([0, 1], n), np.tile(np.arange(n) / 500.0, 2) + np.repeat([0.0, 20.0], n)
    noisy = {"displacement": depth + 1e-9 * RNG.standard_normal(2 * n), "normal_force": depth}
    recording = Recording("twice", t, episode, noisy, Fingertip(0.01), {})
    misfit = common * np.tile(RNG.standard_normal(n), 2) + own * RNG.standard_normal(2 * n)
    z = RNG.standard_normal(2 * n) + misfit
    measured = SimpleNamespace(recording=recording, noise=SimpleNamespace(displacement=1e-9))
    problem = SimpleNamespace(measured=measured, used=np.ones(2 * n, bool), residual=lambda _: z)
    return Comparison(problem, np.zeros(0), fitted=True)


@pytest.mark.parametrize(("common", "own", "share"), [(2.0, 0.0, 1.0), (0.0, 2.0, 0.0), (1.0, 1.0, 0.5)])
def test_the_share_of_the_misfit_that_a_repeated_motion_repeats_is_no_chance(common, own, share) -> None:
    found = replicates(common, own).repeated
    assert found.pairs == 1
    assert found.share == pytest.approx(share, abs=4.0 * found.std)
    assert found.std < 0.05
    assert ("chance" in found.note) == (found.share <= 0.5)


def test_of_noise_alone_nothing_is_said_to_be_repeated() -> None:
    assert replicates(0.0, 0.0).repeated is None


def test_noise_has_no_regime() -> None:
    z = RNG.standard_normal(N)
    here = features(speed=RNG.uniform(0.0, 1e-2, N), indentation=RNG.uniform(0.0, 2e-3, N))
    assert not where([Residuals("normal_force", np.arange(N), 0.01 * z, z)], here)


def test_the_regime_that_is_off_comes_first_with_its_offset_and_share() -> None:
    speed = RNG.uniform(0.0, 9e-3, N)
    phase = RNG.choice([PHASES.index("loading"), PHASES.index("unloading")], N)
    off = (phase == PHASES.index("unloading")) & (speed > 6e-3)
    z = RNG.standard_normal(N) - 4.0 * off
    first = where([Residuals("normal_force", np.arange(N), 0.01 * z, z)], features(phase, speed=speed))[0]
    assert first.regime.startswith("unloading at more than 6")
    assert first.share > 0.9
    assert first.offset == pytest.approx(-0.04, rel=0.05)
    assert "the model reads 40 mN high" in first.note


def test_shares_are_parts_of_one_misfit() -> None:
    z = RNG.standard_normal(N) * (1.0 + 3.0 * (np.arange(N) > 6000))
    here = features(time=np.arange(N) * 0.005, speed=RNG.uniform(0.0, 1e-2, N))
    found = where([Residuals("normal_force", np.arange(N), z, z)], here)
    assert sum(one.share for one in found) == pytest.approx(1.0, abs=0.1)
    assert [one.share for one in found] == sorted((one.share for one in found), reverse=True)


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [("normal_force", 0.0402, "40 mN"), ("speed", 5e-3, "5 mm/s"), ("torque_z", 1.2e-4, "120 uN m"),
     ("temperature", 23.4, "23 degC"), ("normal_force", 0.0, "0 N"), ("contact_radius", 3e-9, "3 nm")],
)  # fmt: skip
def test_numbers_are_said_with_a_fitting_prefix(name, value, text) -> None:
    assert format_quantity(name, value) == text


def test_ranges_are_said() -> None:
    assert format_span("speed", 5e-3, None) == "at more than 5 mm/s"
    assert format_span("indentation", None, 1e-3) == "at a depth of up to 1 mm"
    assert format_span("frequency", 0.0, None) == "while going to and fro"
    assert format_span("time", 240.0, None) == "more than 240 s after the start"
    assert format_span("time_in_contact", 1.0, 2.0) == "1 s to 2 s into the contact"


@pytest.fixture(scope="module")
def plain(bench):
    return compare(bench())


@pytest.fixture(scope="module")
def fitted(bench):
    return fit(bench()).model


@pytest.mark.long
@pytest.mark.slow
def test_the_right_model_has_nothing_to_show_and_the_wrong_one_has(bench, plain) -> None:
    assert plain.error == pytest.approx(1.0, abs=0.03)
    assert not plain.where
    sticky = compare(bench("adhesion"))
    assert sticky.error > 1.5
    assert sticky.where[0].channel == "normal_force"
    assert any("out of contact" in one.regime for one in sticky.where)
    rubbing = compare(bench("load_dependent_friction"))
    assert rubbing.channels["normal_force"].ratio == pytest.approx(1.0, abs=0.03)
    assert {one.channel for one in rubbing.where} <= {"tangential_force", "torque_z"}
    assert rubbing.where


@pytest.mark.slow
def test_a_press_that_takes_a_minute_is_loading_and_no_hold() -> None:
    t = np.arange(0.0, 60.0, 0.05)
    depth = np.interp(t, [0.0, 5.0, 35.0, 50.0, 55.0, 60.0], [-1e-4, -1e-4, 1e-3, 1e-3, -1e-4, -1e-4])
    force = 1.5 * np.maximum(depth / 1e-3, 0.0) ** 1.5 + 1e-3 * RNG.standard_normal(t.size)
    columns = {"displacement": depth + 1e-7 * RNG.standard_normal(t.size), "normal_force": force}
    sensors = {"normal_force": 1e-3, "displacement": 1e-7}
    slow = Recording("slow", t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(0.01), sensors)
    phase = compare(slow).features.phase
    for begin, end, name in ((12.0, 34.0, "loading"), (37.0, 49.0, "hold"), (51.0, 54.0, "unloading")):
        rows = (t > begin) & (t < end)
        assert np.mean(phase[rows] == PHASES.index(name)) > 0.95, name


@pytest.mark.slow
def test_a_zero_of_the_force_sensor_sorts_no_row_by_its_noise(bench, plain) -> None:
    recording = bench()
    force = recording.columns["normal_force"] + 5.0 * recording.sensors["normal_force"]
    moved = replace(recording, columns={**recording.columns, "normal_force": force})
    here, there = plain.features.phase, compare(moved).features.phase
    assert np.mean(here == PHASES.index("out of contact")) > 0.1
    assert np.mean(here == there) > 0.999


@pytest.mark.slow
def test_depths_and_forces_of_a_regime_are_without_the_zeros_of_the_sensors(tip) -> None:
    features = [
        compare(tip(5, kinds=("hold", "ramp"), zeros=zeros)).features for zeros in ((0.0, 0.0), (-0.3, 0.2))
    ]
    for name, std in (("indentation", 5e-6), ("normal_force", 0.01)):
        here, there = (one.values[name] for one in features)
        assert there == pytest.approx(here, abs=3.0 * std)


@pytest.mark.slow
def test_rows_that_stick_under_a_load_are_a_regime(plain) -> None:
    found = plain.features
    assert found.sticking is not None
    assert found.sticking.any()
    assert not np.any(found.sticking & (found.phase == PHASES.index("sliding")))
    assert not np.any(found.sticking & (found.phase == PHASES.index("out of contact")))


@pytest.mark.slow
def test_a_given_model_is_compared_as_it_is(bench, fitted) -> None:
    told = compare(bench(), fitted.with_value("K", 1.9))
    assert not told.fitted
    assert told.error > 1.5
    assert told.problem.unknowns.names == ("zero_displacement", "zero_force")


@pytest.mark.long
@pytest.mark.slow
def test_command_holds_to_the_contract(bench, fitted, tmp_path, capsys) -> None:
    write_recording(bench("adhesion"), tmp_path / "press")
    write_model(fitted, tmp_path / "m.toml")
    assert main(["compare", str(tmp_path / "press"), "--versus", str(tmp_path / "m.toml"), "--json",
                 "-o", str(tmp_path / "pictures")]) == 0  # fmt: skip
    told = json.loads(capsys.readouterr().out)
    for one in told["channels"].values():
        assert {"rmse", "noise", "ratio", "whiteness_p", "coverage95"} <= set(one)
    for one in told["where"]:
        assert {"channel", "regime", "share", "note"} <= set(one)
    assert told["versus"]["error"] > told["error"]
    assert (tmp_path / "pictures" / "normal_force.png").stat().st_size > 1000
    assert (tmp_path / "pictures" / "versus" / "normal_force.png").exists()
