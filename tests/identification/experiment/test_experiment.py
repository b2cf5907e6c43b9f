"""The next experiment: what it promises is what a simulated one achieves."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.identification.reach import greatest_depth, greatest_speed
from vegrip.cli import main
from vegrip.effects import effect
from vegrip.errors import ConfigError, UsageError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.draft.grammar import LAW_PLACES, LAW_SHAPES, LAW_VARIABLES, Law
from vegrip.identification.draft.text import law_text
from vegrip.identification.experiment import NO_EFFECT, Hypotheses, RigLimits, design, hypotheses_of
from vegrip.identification.experiment.design import MIN_SEPARATION_NATS, next_experiment, rig_of
from vegrip.identification.experiment.design_space import MENU, complete_limits, limits_of, read_limits
from vegrip.identification.experiment.hypotheses import (
    chance_to_decide,
    expected_separation,
    measure_separation,
)
from vegrip.identification.fit import fit
from vegrip.identification.recording import Recording, write_recording
from vegrip.identification.simulate import DEFAULT_NOISE, read_protocol, simulate
from vegrip.identification.simulate.protocol import standard
from vegrip.model import paper_model

BASE = paper_model(8e-3)
LIMITS = RigLimits(1.3e-3, 3.0, 0.02, 1.0, 2e-3, 60.0, 5.0)
SEEDS = (1, 2)


def recorded(name: str, share: float, *, tangential: bool = False) -> Recording:
    """Return a recording of the standard protocol with an effect at a share of its declared size."""
    amount = next(p for p in effect(name).parameters if p.null is not None)
    truth = BASE.with_effect(effect(name)).with_value(amount.symbol, share * amount.default)
    sensors = DEFAULT_NOISE if tangential else {"normal_force": 0.01, "displacement": 5e-6}
    whole = standard(truth)
    protocol = whole if tangential else replace(whole, episodes=whole.episodes[2:9], notes=())
    return simulate(truth, protocol, sensors=sensors, rate=100.0)


@pytest.fixture(scope="module")
def softened() -> Hypotheses:
    return hypotheses_of(fit(recorded("mullins_softening", 0.5)), ["mullins_softening", "permanent_set"])


@pytest.fixture(scope="module")
def slow() -> Hypotheses:
    return hypotheses_of(
        fit(recorded("second_relaxation", 0.3)), ["second_relaxation", "power_law_relaxation"]
    )


def item(name: str):
    return next(one for one in MENU if one.name == name)


@pytest.mark.parametrize(
    ("pair", "name", "amplitudes"),
    [
        ("softened", "growing peaks, then a small one", {"depth": 1.0, "time": 1.0}),
        ("softened", "holds at three depths", {"depth": 1.0, "time": 2.0}),
        ("slow", "one hold", {"depth": 1.0, "time": 20.0}),
        ("slow", "triangles", {"depth": 1.0, "frequency": 2.0}),
    ],
)
def test_a_simulated_experiment_achieves_what_was_expected(request, pair, name, amplitudes) -> None:
    contest = request.getfixturevalue(pair)
    protocol = item(name).protocol(rig_of(contest, LIMITS), amplitudes)
    expected = expected_separation(contest, protocol, refit=True)
    found = [measure_separation(contest, protocol, seed) for seed in SEEDS]
    for direction, nats in expected.pairs.items():
        mean = np.mean([one[direction] for one in found])
        # scatter of the mean of a log-likelihood ratio, and what each side gains by fitting its noise
        assert abs(mean - nats) < 3.0 * np.sqrt(2.0 * nats / len(SEEDS)) + 4.0


def test_growing_peaks_tell_softening_from_set_and_a_hold_does_not(softened) -> None:
    rig = rig_of(softened, LIMITS)
    peaks = item("growing peaks, then a small one").protocol(rig, {"depth": 1.0, "time": 1.0})
    hold = item("one hold").protocol(rig, {"depth": 1.0, "time": 10.0})
    assert expected_separation(softened, peaks).nats > 5.0 * max(
        expected_separation(softened, hold).nats, 1.0
    )


def test_twice_the_experiment_tells_twice_as_much(softened) -> None:
    amplitudes = {"depth": 1.0, "time": 1.0}
    once = item("growing peaks, then a small one").protocol(rig_of(softened, LIMITS), amplitudes)
    single, double = (expected_separation(softened, protocol).nats for protocol in (once, once.repeated(2)))
    assert 1.7 < double / single < 2.6  # a little more: the priors count once


def test_strokes_in_air_tell_nothing_of_the_contact(softened) -> None:
    protocol = item("strokes in air").protocol(rig_of(softened, LIMITS), {"depth": 1.0})
    assert expected_separation(softened, protocol).nats < 0.1


@pytest.fixture(scope="module")
def planned(softened):
    return design(softened, LIMITS, is_thorough=False)


@pytest.mark.long
def test_the_best_one_decides_within_the_limits(softened, planned) -> None:
    best = planned.best
    assert best is not None
    assert best.nats > 15.0
    assert best.whole.duration <= LIMITS.duration
    assert greatest_depth(best.whole) <= LIMITS.depth * (1.0 + 1e-9)
    assert greatest_speed(best.whole) <= LIMITS.speed * (1.0 + 1e-9)
    for model in softened.models.values():
        pressed = simulate(model, best.whole, sensors={"normal_force": 0.0, "displacement": 0.0})
        assert pressed.columns["normal_force"].max() <= 1.02 * LIMITS.force
    assert "no tangential force" in planned.left_out["pulls at four loads"]
    assert min(measure_separation(softened, best.whole, seed=9).values()) > MIN_SEPARATION_NATS


def test_what_no_experiment_tells_is_said() -> None:
    models = {"sensor_lag": BASE.with_effect(effect("sensor_lag")).with_value("tau", 2e-3)}
    same = Hypotheses(
        {**models, "force_drift": models["sensor_lag"]},
        (),
        {"normal_force": 0.01, "displacement": 5e-6},
        50.0,
    )
    found = design(same, LIMITS, is_thorough=False)
    assert found.best is None
    assert not found.as_dict()["separates"]
    assert "no experiment on the menu" in found.advice
    assert effect("sensor_lag").experiment in found.advice


@pytest.mark.parametrize("one", MENU, ids=lambda one: one.name)
def test_every_item_keeps_to_depth_and_speed(one, softened) -> None:
    rig = rig_of(softened, LIMITS)
    for amplitudes in one.choices():
        protocol = one.protocol(rig, amplitudes)
        assert greatest_depth(protocol) <= rig.depth * (1.0 + 1e-9)
        assert greatest_speed(protocol) <= rig.speed * (1.0 + 1e-9)


def test_a_force_limit_makes_the_press_shallower(softened) -> None:
    depths = [
        rig_of(softened, complete_limits(RigLimits(force=force), LIMITS)).depth for force in (0.2, 0.6, 50.0)
    ]
    assert all(a < b for a, b in pairwise(depths))
    assert depths[-1] == LIMITS.depth


def test_one_effect_is_told_from_nothing_and_one_not_seen_stands_in_at_its_declared_size() -> None:
    start = fit(recorded("mullins_softening", 0.5))
    contest = hypotheses_of(start, ["adhesion"])
    assert contest.names == ("adhesion", NO_EFFECT)
    assert contest.assumed == ("adhesion",)
    with pytest.raises(UsageError, match="already"):
        hypotheses_of(start, ["relaxation", "adhesion"])
    with pytest.raises(UsageError, match="name two"):
        hypotheses_of(start, [NO_EFFECT])
    with pytest.raises(UsageError, match="no temperature was recorded"):
        hypotheses_of(start, ["adhesion", "temperature_shift"])


def test_a_law_whose_amount_may_be_none_is_told_from_nothing_where_it_is_there(tmp_path) -> None:
    """It imitates its absence at no cost, which says nothing of an experiment."""
    law = Law(LAW_PLACES["force"], LAW_VARIABLES["way"], LAW_SHAPES["saturating"], 20.0)
    (tmp_path / "worn.py").write_text(law_text(law, "worn", {}, {"c": -0.25, "s": 0.3}))
    worn = BASE.with_effect(effect(str(tmp_path / "worn.py")))
    sensors = {"normal_force": 5e-3, "displacement": 1e-6}
    contest = Hypotheses({"worn": worn, NO_EFFECT: BASE}, (), sensors, 100.0)
    protocol = item("triangles").protocol(rig_of(contest, LIMITS), {"depth": 1.0, "frequency": 2.0})
    expected = expected_separation(contest, protocol, refit=True)
    assert list(expected.pairs) == [("worn", NO_EFFECT)]
    assert expected.nats > 20.0
    assert measure_separation(contest, protocol, seed=1)["worn", NO_EFFECT] > 20.0


def test_limits_are_those_of_the_recording_where_nothing_is_said(tmp_path) -> None:
    recording = recorded("second_relaxation", 1.0, tangential=True)
    found = limits_of(recording)
    assert found.depth == pytest.approx(recording.columns["displacement"].max(), rel=0.02)
    assert found.tangential_force > 0.3
    (tmp_path / "rig.toml").write_text("force = 9.0\nduration = 30\n")
    both = complete_limits(read_limits(tmp_path / "rig.toml"), found)
    assert (both.force, both.duration, both.depth) == (9.0, 30.0, found.depth)
    (tmp_path / "rig.toml").write_text("force = -1.0\n")
    with pytest.raises(ConfigError, match="must lie in"):
        read_limits(tmp_path / "rig.toml")


def test_chance_grows_with_nats() -> None:
    assert chance_to_decide(0.0) == 0.0
    assert chance_to_decide(5.0) == pytest.approx(0.5)
    assert chance_to_decide(20.0) > 0.99


@pytest.mark.long
@pytest.mark.slow
def test_the_command_writes_a_protocol_that_reads_back(tmp_path, capsys) -> None:
    write_recording(recorded("mullins_softening", 0.5), tmp_path / "press")
    press, out = str(tmp_path / "press"), tmp_path / "next.toml"
    given = ["--candidates", "mullins_softening,permanent_set", "--duration", "30", "--normal-force", "2.5"]
    assert (
        main(["experiment", press, *given, "-o", str(out), "--plot", str(tmp_path / "p.png"), "--json"]) == 0
    )
    told = json.loads(capsys.readouterr().out)
    assert told["separates"]
    assert min(told["achieved"].values()) > MIN_SEPARATION_NATS
    protocol = read_protocol(out)
    assert protocol.duration == pytest.approx(told["best"]["duration"])
    assert (tmp_path / "p.png").stat().st_size > 5000
    assert main(["experiment", press, "--candidates", "magic,adhesion"]) == 3
    assert main(["experiment", press, "--candidates", "adhesion", "--normal-force", "-1"]) == 3
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.long
def test_an_ambiguous_diagnosis_has_its_experiment() -> None:
    found = diagnose(recorded("second_relaxation", 0.5), most=1)
    tried = [one.candidate.name for one in found.search.steps[0].tried][:2]
    found.__dict__["indistinguishable"] = [tried]  # as if the evidence had been equal
    told = found.as_dict(next_experiment(found))["experiment"]
    assert sorted(told["between"]) == sorted(tried)
    assert told["items"]
    assert set(told["suggestions"]) <= set(tried)
    assert json.dumps(told)
