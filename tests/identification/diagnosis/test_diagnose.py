"""The whole diagnosis on recordings whose hidden effect is known, made by code that shares no physics."""

import json

import pytest

from vegrip.cli import main
from vegrip.effects import effect
from vegrip.errors import UsageError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.discrepancy import find_discrepancy
from vegrip.identification.diagnosis.error_ladder import add_effect, build_ladder
from vegrip.identification.fit import fit
from vegrip.identification.fit.fitting import base_model
from vegrip.identification.recording import Recording, write_recording
from vegrip.model import read_model

pytestmark = pytest.mark.slow

HIDDEN = {
    "adhesion": ("force law", 0.05, 0.2, lambda v: v["pull"] * v["K"]),
    # holds of 1.5 s tell the product, the rest of it is the prior
    "second_relaxation": ("memory", 0.1 * 0.2, 0.4, lambda v: v["c2"] * v["nu2"]),
    "sensor_lag": ("force law", 5e-3, 0.1, lambda v: v["tau"]),
    "load_dependent_friction": (None, 0.2, 0.1, lambda v: v["g_N"]),
}
"""Where the curve shows it, what is hidden, how well it comes out (a share), and of which parameters."""

OFTEN_NOT = ("second_relaxation", "sensor_lag")


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_nothing_is_named_where_nothing_is_hidden(bench, seed) -> None:
    told = diagnose(bench(seed=seed)).as_dict()
    assert told["verdict"] == "adequate"
    assert told["named"] == []
    assert told["unexplained"] is None
    assert told["error"]["after"] == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.long) if name in OFTEN_NOT else name for name in HIDDEN],
)
def test_the_hidden_effect_is_named_with_its_place_and_size_and_the_error_falls_to_the_noise(
    bench, name
) -> None:
    place, hidden, rel, amount = HIDDEN[name]
    found = diagnose(bench(name))
    told = found.as_dict()
    if name == "second_relaxation":  # holds of 1.5 s tell it from a power law by 17 nats only
        assert told["indistinguishable"] == [["second_relaxation", "power_law_relaxation"]]
    else:
        assert told["verdict"] == "named"
        assert told["named"] == [name]
    assert told["effects"][0]["name"] == name
    assert told["effects"][0]["probability"] > 0.99
    assert told["error"]["before"] > 1.03
    assert told["error"]["after"] == pytest.approx(1.0, abs=0.05)
    if place is not None:
        assert find_discrepancy(found.search.first).place == place
    values = {symbol: value.value for symbol, value in found.model.values.items()}
    assert amount(values) == pytest.approx(hidden, rel=rel)
    before, after = build_ladder(found)
    assert (before.effect, after.effect) == (None, name)
    assert after.error < before.error
    assert after.heldout_error < before.heldout_error
    assert after.heldout_error == pytest.approx(1.0, abs=0.06)


def test_a_weak_effect_is_still_seen(bench) -> None:
    found = diagnose(bench("sensor_lag", 0.2))  # a millisecond, of which 200 Hz does not tell the shape
    assert found.verdict == "ambiguous"
    assert set(found.indistinguishable[0]) == {"sensor_lag", "sensor_delay"}


def test_a_model_that_has_the_effect_is_adequate(bench) -> None:
    sticky = bench("adhesion")
    assert diagnose(sticky, add_effect("adhesion", fit(sticky))[0].model).verdict == "adequate"


def test_same_recording_same_answer(tip, small) -> None:
    again = diagnose(tip(13, kinds=("hold", "ramp", "hold"), pull=0.06))
    assert again.as_dict() == small.as_dict()


def test_what_the_recording_cannot_show_is_said(bench) -> None:
    recording = bench()
    columns = {name: recording.columns[name] for name in ("displacement", "normal_force")}
    bare = Recording("bare", recording.t, recording.episode, columns, recording.fingertip, recording.sensors)
    told = diagnose(bare).as_dict()
    assert told["verdict"] == "adequate"
    assert "temperature" in told["out_of_sight"]["temperature_shift"]
    assert "slip" in told["out_of_sight"]["load_dependent_friction"]
    assert "tangential" in told["out_of_sight"]["cross_talk"]


def test_add_puts_in_one_effect_and_refuses_what_cannot_be(bench) -> None:
    start = fit(bench("sensor_lag"))
    after, before = add_effect("sensor_lag", start)
    assert after.error == pytest.approx(1.0, abs=0.04)
    assert before.error == pytest.approx(start.error)
    assert after.model.values["tau"].value == pytest.approx(5e-3, rel=0.1)
    with pytest.raises(UsageError, match="already"):
        add_effect("relaxation", start)
    with pytest.raises(UsageError, match="cannot show"):
        add_effect("contact_radius_law", fit(_without_slip(bench())))


def _without_slip(recording: Recording) -> Recording:
    kept = {k: v for k, v in recording.columns.items() if k in ("displacement", "normal_force")}
    return Recording("bare", recording.t, recording.episode, kept, recording.fingertip, recording.sensors)


@pytest.mark.long
def test_commands_hold_to_the_contract(bench, tmp_path, capsys) -> None:
    name = "load_dependent_friction"
    write_recording(bench(name), tmp_path / "press")
    press, model = str(tmp_path / "press"), tmp_path / "m.toml"
    assert main(["diagnose", press, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {
        "verdict",
        "effects",
        "named",
        "indistinguishable",
        "error",
        "where",
        "unexplained",
        "experiment",
    } <= set(told)
    assert set(told["error"]) == {"before", "after", "noise_floor"}
    assert {"name", "probability", "error_after", "heldout_gain"} <= set(told["effects"][0])
    assert main(["add", name, press, "-o", str(model), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["error"]["after"] < told["error"]["before"]
    assert "g_N" in told["parameters"]
    assert name in [one.name for one in read_model(model).effects]
    report = str(tmp_path / "report")
    assert main(["refine", press, "-o", str(model), "--force", "--report", report, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [rung["effect"] for rung in told["ladder"]] == [None, name]
    assert told["verdict"] == "named"
    assert (tmp_path / "report" / "ladder.png").exists()
    assert main(["add", "no_such_effect", press]) == 3
    assert "Traceback" not in capsys.readouterr().err


def test_base_model_of_a_tip_has_none_of_the_candidates(bench) -> None:
    assert effect("adhesion").name not in [one.name for one in base_model(bench()).effects]
