"""Laws of what is learned: only from motion, judged with hysteresis, kept and given back."""

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.errors import ConfigError
from vegrip.estimator import ContactEstimator, EstimatorSettings, Learner, SensorNoise
from vegrip.estimator.estimator import LOST
from vegrip.estimator.learning import NARROW, WIDE, _is_sound, fingerprint, restored, save
from vegrip.messages import FingertipState
from vegrip.model import paper_model

PERIOD = 4e-3


@pytest.fixture(scope="module")
def model():
    return paper_model(8e-3)


@pytest.fixture(scope="module")
def truth(model):
    return model.with_value("K", 1.2 * model.values["K"].value).with_value("c1", 0.35)


def states(truth, t, depth, drift=0.0, seed=3):
    rng = np.random.default_rng(seed)
    force = truth.simulate(t, depth).normal_force + drift + 0.01 * rng.standard_normal(t.size)
    seen = depth + 5e-6 * rng.standard_normal(t.size)
    return [
        FingertipState(int(1e9 * t[i]), "tip", i, force[i], 0.1, 0.0, 0.0, seen[i]) for i in range(t.size)
    ]


def pressed(duration):
    """A hold, a shallow hold, and a hold that lasts."""
    t = np.arange(0.0, duration, PERIOD)
    knots, depths = [0.0, 0.5, 1.0, 4.0, 5.0, 8.0, 8.6], [-1e-4, -1e-4, 1e-3, 1e-3, 3e-4, 3e-4, 1e-3]
    return t, np.interp(t, knots, depths)


def learn(estimator, given):
    learner = Learner(estimator)
    for i, state in enumerate(given):
        estimator.assimilate(state)
        if i % 50 == 0:
            learner.look(state.stamp)
    return learner


def test_a_tip_that_rests_teaches_nothing(model, truth):
    """A sensor that drifts by 0.18 N in a hold of a minute and a half is not taken for a softer tip."""
    t, depth = pressed(120.0)
    drift = 2e-3 * np.maximum(t - 30.0, 0.0)
    stiffness = {}
    for rest in (20.0, 1e6):
        estimator = ContactEstimator(model, SensorNoise(), EstimatorSettings(learning_rest=rest))
        learn(estimator, states(truth, t, depth, drift))
        stiffness[rest] = estimator.value("K").value / truth.values["K"].value
        assert estimator.is_excited == (rest > 1e3)
    assert abs(stiffness[20.0] - 1.0) < 0.02
    assert abs(stiffness[1e6] - 1.0) > 0.03, "without the rule it would be; otherwise this test shows nothing"


def test_what_moved_in_contact_is_learned_and_said_to_be(model, truth):
    t, depth = pressed(12.0)
    learned = learn(ContactEstimator(model, SensorNoise()), states(truth, t, depth)).learned
    assert set(learned) == {"K", "p", "c1", "nu1", "mu"}
    for symbol in ("K", "c1"):
        assert learned[symbol].valid
        assert learned[symbol].filtered == pytest.approx(truth.values[symbol].value, rel=0.05)
        assert learned[symbol].excited > 5.0
    assert not learned["mu"].valid, "nothing slipped"


def test_air_teaches_nothing(model, truth):
    t = np.arange(0.0, 4.0, PERIOD)
    learned = learn(ContactEstimator(model, SensorNoise()), states(truth, t, np.full(t.size, -1e-3))).learned
    for symbol, one in learned.items():
        assert one.filtered == model.values[symbol].value
        assert (one.valid, one.excited) == (False, 0.0)


class Spread:
    """An estimator whose one spread is set by hand."""

    def __init__(self, estimator):
        self.estimator, self.share, self.is_known = estimator, 1.0, True

    def __getattr__(self, name):
        return getattr(self.estimator, name)

    def value(self, symbol):
        known = self.estimator.value(symbol)
        std = self.share * self.estimator.model.values[symbol].std
        return dataclasses.replace(known, std=std, valid=self.is_known)


def test_validity_has_hysteresis(model, truth):
    t, depth = pressed(3.0)
    estimator = ContactEstimator(model, SensorNoise())
    learn(estimator, states(truth, t, depth))
    by_hand = Spread(estimator)
    learner, between = Learner(by_hand), 0.5 * (NARROW + WIDE)
    seen = []
    for i, share in enumerate((1.0, between, 0.9 * NARROW, between, 1.1 * WIDE, between)):
        by_hand.share = share
        seen.append(learner.look(i * 200_000_000)["K"].valid)
    assert seen == [False, False, True, True, False, False]


def test_a_value_is_filtered_as_a_mean_with_the_prior_and_after_ten_seconds_as_by_a_low_pass(model, truth):
    t, depth = pressed(3.0)
    estimator = ContactEstimator(model, SensorNoise())
    learn(estimator, states(truth, t, depth))
    learner, step = Learner(estimator), 0.5
    prior, raw = model.values["K"].value, estimator.value("K").value
    assert abs(raw / prior - 1.0) > 0.1
    for look in range(41):
        found = learner.look(round(look * step * 1e9))["K"]
        assert found.excited == pytest.approx(look * step)
        left = 1.0 / (look + 1.0) if look <= 20 else (1.0 / 21.0) * (10.0 / 10.5) ** (look - 20)
        assert (found.filtered - raw) / (prior - raw) == pytest.approx(left)
    assert learner.look(0)["K"].excited == pytest.approx(20.0)  # a clock that went back


@pytest.mark.parametrize(
    ("regime", "nis", "sound"), [("", 2.0, True), ("", 2.01, False), ("", math.nan, True), (LOST, 1.0, False)]
)
def test_nothing_is_learned_of_a_misfit_larger_than_the_noise(model, regime, nis, sound):
    health = dataclasses.replace(ContactEstimator(model, SensorNoise()).health(), regime=regime, nis=nis)
    assert _is_sound(health) == sound


def test_what_was_learned_comes_back_as_a_wider_prior_to_the_same_model(model, truth, tmp_path):
    t, depth = pressed(12.0)
    learner = learn(ContactEstimator(model, SensorNoise()), states(truth, t, depth))
    path = tmp_path / "hand" / "tip.json"
    assert save(learner, path) == sum(one.valid for one in learner.learned.values()) > 0
    again = restored(model, path)
    for symbol, one in learner.learned.items():
        if one.valid:
            assert again.values[symbol].value == one.filtered
            assert again.values[symbol].std == min(2.0 * one.raw.std, model.values[symbol].std)
        else:
            assert again.values[symbol] == model.values[symbol]
    assert list(path.parent.iterdir()) == [path], "nothing half written is left"


def test_without_a_file_the_model_is_as_it_was(model, tmp_path):
    assert restored(model, tmp_path / "none.json") is model


def content(model, **changes):
    sound = {"version": 1, "fingerprint": fingerprint(model), "parameters": {"K": {"value": 1.0, "std": 0.1}}}
    return json.dumps(sound | changes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (lambda _: "not json", "does not hold"),
        (lambda _: "[]", "does not hold"),
        (lambda model: content(model, version=2), "version 2"),
        (lambda model: content(model.with_effect(effect("adhesion"))), "another model"),
        (lambda model: content(model, parameters={"K": {"value": -1.0, "std": 0.1}}), "not within"),
        (lambda model: content(model, parameters={"K": {"value": 1.0, "std": math.nan}}), "not within"),
        (lambda model: content(model, parameters={"K": {"value": 1.0, "std": 0.0}}), r"\+- 0, not within"),
        (lambda model: content(model, parameters={"K": {"value": 1.0}}), "lacks"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_with_a_remedy(text, words, model, tmp_path):
    path = tmp_path / "tip.json"
    path.write_text(text(model))
    with pytest.raises(ConfigError, match=words) as caught:
        restored(model, path)
    assert "delete" in str(caught.value)


def test_a_fingerprint_tells_models_apart(model):
    others = (paper_model(9e-3), model.with_effect(effect("adhesion")))
    assert len({fingerprint(one) for one in (model, *others)}) == 3
    assert fingerprint(model) == fingerprint(model.with_value("K", 2.0))


def scaled(**changes):
    """Return all of a model that a fingerprint is made of, with ``changes``."""
    parameter = {"symbol": "K", "unit": "N/m", "transform": "log"}
    own = {name: changes.pop(name) for name in parameter if name in changes}
    name = changes.pop("name", "power_law_stiffness")
    made = SimpleNamespace(name=name, parameters=[SimpleNamespace(**parameter | own)])
    return SimpleNamespace(**{"tip_radius": 8e-3, "reference_depth": 1e-3, "effects": [made]} | changes)


@pytest.mark.parametrize(
    "change",
    [
        {"tip_radius": 9e-3},
        {"reference_depth": 2e-3},
        {"name": "exponential_stiffness"},
        {"symbol": "k"},
        {"unit": "N/mm"},
        {"transform": "none"},
        {"effects": []},
    ],
    ids=lambda change: next(iter(change)),
)
def test_a_number_that_would_mean_another_thing_is_of_another_fingerprint(change):
    assert fingerprint(scaled()) == fingerprint(scaled())
    assert fingerprint(scaled(**change)) != fingerprint(scaled())


@pytest.mark.parametrize(("share", "wide"), [(0.1, 0.2), (0.5, 1.0), (0.6, 1.0), (30.0, 1.0)])
def test_what_comes_back_is_twice_as_wide_and_no_wider_than_it_was_known_before(model, tmp_path, share, wide):
    known = model.values["K"]
    entry = {"value": known.value, "std": share * known.std}
    (tmp_path / "tip.json").write_text(content(model, parameters={"K": entry}))
    assert restored(model, tmp_path / "tip.json").values["K"].std == pytest.approx(wide * known.std)


def test_what_was_valid_stays_so_while_nothing_moves_and_not_beyond_a_model_that_is_lost(model):
    """A look in which nothing is learned keeps value and validity; a misfit takes the validity."""
    estimator = Spread(ContactEstimator(model, SensorNoise()))
    estimator.is_excited, estimator.share = True, 0.5 * NARROW
    sound = dataclasses.replace(estimator.health(), regime="", nis=1.0)
    said = sound
    estimator.health = lambda: said
    learner, seen = Learner(estimator), []
    for look, (excited, nis) in enumerate(
        [(False, 1.0), (True, 1.0), (False, 1.0), (True, 3.0), (True, 1.0), (False, 3.0), (False, 1.0)]
    ):
        estimator.is_excited, said = excited, dataclasses.replace(sound, nis=nis)
        seen.append(learner.look(look * 200_000_000)["K"].valid)
    assert seen == [False, True, True, False, True, False, False]


@pytest.mark.parametrize(
    "without", [{"is_known": False}, {"is_excited": False}, {"share": math.inf}, {"share": math.nan}]
)
def test_of_a_value_that_is_not_known_or_does_not_move_nothing_is_learned(model, without):
    estimator = Spread(ContactEstimator(model, SensorNoise()))
    estimator.is_excited, estimator.share = True, 0.5 * NARROW
    learner = Learner(estimator)
    first, moved = learner.look(0)["K"], learner.look(500_000_000)["K"]
    assert (first.excited, moved.excited, moved.valid) == (0.0, 0.5, True)
    for name, value in without.items():
        setattr(estimator, name, value)
    after = learner.look(1_000_000_000)["K"]
    assert (after.excited, after.filtered, after.valid) == (0.5, moved.filtered, True)
