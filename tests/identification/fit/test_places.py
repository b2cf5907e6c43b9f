"""Places that have laws of their own: the values of each are those of it alone, the sensors are common."""

import dataclasses
import json

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.effects import effect
from vegrip.errors import RecordingError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.fit import fit, problem
from vegrip.identification.fit.solve import _step
from vegrip.identification.recording import Recording, write_recording
from vegrip.identification.recording.data import join_recordings
from vegrip.model import paper_model, read_model

TAU = 0.04  # [s]
SOFTER = 0.6
KINDS = ("hold", "ramp", "hold", "ramp")


def elsewhere(recording: Recording, softer: float) -> Recording:
    """Return the recording with every other episode pressed at a place that is softer."""
    force = recording.columns["normal_force"]
    number = np.unique(recording.episode, return_inverse=True)[1]
    columns = {**recording.columns, "normal_force": np.where(number % 2, softer, 1.0) * force}
    return dataclasses.replace(recording, columns=columns)


@pytest.fixture(scope="module")
def two_places(tip):
    return elsewhere(tip(21, kinds=KINDS, rate=100.0), SOFTER)


def test_each_place_has_its_stiffness_and_the_others_their_own(two_places) -> None:
    one = fit(two_places)
    own = fit(two_places, laws=(0, 1, 0, 1))
    assert one.laws == []
    assert own.error < 1.1 < one.error
    first, second = own.laws
    assert second["K"] / first["K"] == pytest.approx(SOFTER, rel=0.03)
    assert second["p"] == pytest.approx(first["p"], abs=0.03)
    assert f"{second['K']:.3g} to {first['K']:.3g} N" in own.laws_note
    values, told = own.model.values, own.as_dict()["parameters"]
    for symbol, middle in (
        ("K", np.sqrt(first["K"] * second["K"])),
        ("c1", (first["c1"] + second["c1"]) / 2),
    ):
        assert values[symbol].value == told[symbol]["value"] == pytest.approx(middle)
    assert own.as_dict()["laws"] == own.laws
    assert not [text for text in fit(two_places, laws="episode").warnings() if "_at_" in text]


@pytest.mark.long
def test_more_episodes_than_memory_holds_are_refused_in_a_sentence_and_left_out_by_a_diagnosis(
    two_places, monkeypatch
) -> None:
    monkeypatch.setattr(problem, "MOST_DERIVATIVES", 10.0 * len(two_places))
    for asked in ({"laws": "episode"}, {"zeros": "episode"}):
        with pytest.raises(RecordingError, match="4 episodes with zeros or laws of their own are"):
            fit(two_places, **asked)
    assert diagnose(two_places, most=0).verdict == "unexplained"


def test_the_command_says_so_and_writes_values_between_those_of_the_places(
    two_places, tmp_path, capsys
) -> None:
    write_recording(two_places, tmp_path / "two")
    file = tmp_path / "two.toml"
    asked = ["fit", str(tmp_path / "two"), "-o", str(file), "--laws-each-episode"]
    assert main([*asked, "--json"]) == 0
    laws = [law["K"] for law in json.loads(capsys.readouterr().out)["laws"]]
    assert len(laws) == 4
    assert min(laws) < read_model(file).values["K"].value < max(laws)
    assert main([*asked, "--force"]) == 0
    assert "of 4 episodes has a stiffness of its own" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(("share", "seed"), [(-0.05, 31), (-0.15, 33)])
def test_a_place_whose_share_lies_at_its_bound_does_not_end_the_fit(tip, share, seed) -> None:
    """A place whose force grows in a hold wants less than no relaxation."""
    grows, falls = (
        tip(seed + i, kinds=("hold", "ramp"), branches=((each, 3.0),)) for i, each in enumerate((share, 0.6))
    )
    found = fit(join_recordings([grows, falls], "both"), laws=(0, 0, 1, 1))
    problem, best = found.problem, found.optimum
    J = problem.jacobian(best.u)
    _, foretold = _step(problem.unknowns, best.u, J.T @ best.residual, J.T @ J, 0.0)
    assert 0.0 <= foretold < 0.002 * best.cost
    assert found.laws[0]["c1"] < 0.02
    assert found.laws[1]["c1"] == pytest.approx(0.6, abs=0.02)


def test_friction_and_what_is_added_are_the_same_everywhere(two_places) -> None:
    model = paper_model(two_places.fingertip.radius).with_effect(effect("second_relaxation"))
    found = fit(two_places, model, laws="episode")
    assert set(found.laws[0]) == {"K", "p", "c1", "nu1"}


def test_a_place_is_fitted_as_if_it_were_alone(two_places) -> None:
    alone = two_places.select(two_places.episode % 2 == 1)
    K = fit(alone).model.values["K"]
    assert fit(two_places, laws=(0, 1, 0, 1)).laws[1]["K"] == pytest.approx(K.value, rel=0.02)


@pytest.mark.parametrize("added", [(), ("permanent_set",)])
@pytest.mark.parametrize("own", ["laws", "zeros"])
def test_derivatives_of_all_places_at_once_are_those_of_each(two_places, own, added) -> None:
    """Those of the zeros too, also where an episode remembers those before it."""
    model = paper_model(two_places.fingertip.radius)
    for name in added:
        model = model.with_effect(effect(name))
    found = fit(two_places, model, **{own: "episode"})
    problem, u = found.problem, found.optimum.u
    told, k = problem.jacobian(u), problem.unknowns
    for j, name in enumerate(k.names):
        moved = u.copy()
        moved[j] += 1e-4 * k.std[j]
        apart = (problem.residual(moved) - problem.residual(u)) / (1e-4 * k.std[j])
        np.testing.assert_allclose(told[:, j], apart, atol=1e-6 * np.abs(apart).max(), err_msg=name)
    problem.threads = 2
    np.testing.assert_array_equal(problem.jacobian(u), told)


def test_one_law_for_all_is_the_model_without_places(tip) -> None:
    plain = tip(22, kinds=("hold", "ramp"))
    assert fit(plain).optimum.cost == fit(plain, laws=(7, 7)).optimum.cost


@pytest.fixture(scope="module")
def late_places(tip):
    return elsewhere(tip(23, kinds=KINDS, late=("lag", TAU), rate=100.0), SOFTER)


def test_a_lag_is_measured_beside_places_that_differ(late_places) -> None:
    model = paper_model(late_places.fingertip.radius).with_effect(effect("sensor_lag"))
    found = fit(late_places, model, laws="episode")
    assert found.model.values["tau"].value == pytest.approx(TAU, rel=0.2)
    assert found.laws[1]["K"] / found.laws[0]["K"] == pytest.approx(SOFTER, rel=0.05)


@pytest.mark.long
def test_a_lag_is_named_beside_places_that_differ(late_places) -> None:
    found = diagnose(late_places, most=1)
    assert {"sensor_lag"} == set(found.named) or ["sensor_lag", "sensor_delay"] in found.indistinguishable
    assert found.model.values["tau"].value == pytest.approx(TAU, rel=0.2)
    assert any("of 4 episodes has a stiffness of its own" in doubt.text for doubt in found.doubts)


@pytest.mark.long
def test_zeros_that_shift_between_episodes_are_no_other_places(tip) -> None:
    """As a rig's are whose touch is sought trial by trial: laws of each episode would make up for them."""
    recording = tip(24, kinds=("hold", "ramp", "hold"))
    shift = np.array([-40e-6, 60e-6, 90e-6])[np.unique(recording.episode, return_inverse=True)[1]]
    columns = {**recording.columns, "displacement": recording.columns["displacement"] + shift}
    found = diagnose(dataclasses.replace(recording, columns=columns), most=1)
    assert (found.verdict, found.named) == ("adequate", [])
    said = [doubt.text for doubt in found.doubts if "of its own" in doubt.text]
    assert len(said) == 1
    assert "each of 3 episodes has zeros of its own" in said[0]
    assert "--zeros-each-episode" in said[0]
    assert found.start.laws == []


@pytest.mark.long
def test_what_only_differs_between_episodes_names_nothing(two_places) -> None:
    found = diagnose(two_places, most=1)
    assert (found.verdict, found.named) == ("unexplained", [])
    assert any("has a stiffness of its own" in doubt.text for doubt in found.doubts)
