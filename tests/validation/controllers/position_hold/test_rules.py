"""What the rules promise: a constant holds or slips, a forecast knows its pads once it has met them."""

import json
from pathlib import Path

import numpy as np
import pytest

from validation.controllers.position_hold.__main__ import main
from validation.controllers.position_hold.controllers import GUARD, ElasticAgain
from validation.controllers.position_hold.forecast import HoldForecast
from validation.controllers.position_hold.gripper import Gripper
from validation.controllers.position_hold.pad import Pad
from validation.controllers.position_hold.scenario import Load
from validation.controllers.position_hold.study import KNOBS, figures_of, trials_of
from validation.controllers.position_hold.trial import HoldResult, HoldTrial, run_holds

PAD = Pad(11e-3, 2.0, 1.6, (0.25, 0.2), (2.0, 0.05), 0.8)
CLOSE_N = 4.0


def closed(gripper: Gripper, forecast: HoldForecast) -> None:
    """Close to CLOSE_N, the estimator looking on."""
    moving = True
    while moving:
        forecast.feel(gripper.sense())
        moving = not gripper.move(lambda _, force: force >= CLOSE_N)


def held(gripper: Gripper, forecast: HoldForecast, duration: float) -> None:
    """Hold for ``duration`` [s], the estimator looking on."""
    end = gripper.time + duration
    while gripper.time < end:
        forecast.feel(gripper.sense())
        gripper.stand()


def true_left(gripper: Gripper, duration: float) -> float:
    """Return the part of the force that is really left after ``duration`` [s]."""
    pressed = gripper.pressed
    return pressed.force_after(pressed.depth, duration) / pressed.force


def test_of_pads_that_were_held_before_the_forecast_knows_what_will_be_left() -> None:
    gripper, forecast = Gripper(PAD, np.random.default_rng(0)), HoldForecast()
    closed(gripper, forecast)
    before = forecast.left_after(np.array([60.0]))[:, 0]
    held(gripper, forecast, 60.0)
    gripper.open(600.0)
    closed(gripper, forecast)
    left = forecast.left_after(np.array([1.0, 10.0, 60.0]))
    truth = [true_left(gripper, t) for t in (1.0, 10.0, 60.0)]
    assert np.mean(left, axis=0) == pytest.approx(truth, rel=0.06)
    assert np.std(left[:, 2]) < 0.5 * np.std(before)


def test_before_the_material_was_met_the_spread_of_the_forecast_contains_the_truth() -> None:
    gripper, forecast = Gripper(PAD, np.random.default_rng(0)), HoldForecast()
    closed(gripper, forecast)
    left = forecast.left_after(np.array([60.0]))[:, 0]
    assert np.quantile(left, 0.02) < true_left(gripper, 60.0) < np.quantile(left, 0.98)


def test_a_constant_that_is_too_small_slips_and_one_that_is_large_takes_more_force() -> None:
    small, large = (run_holds(HoldTrial("elastic", knob, 3, 0))[0] for knob in (0.1, 1.6))
    assert small.slipped
    assert not large.slipped
    assert large.force > small.force
    assert large.force / large.least > large.oracle / large.least > 1.0


def test_with_everything_known_one_closing_just_suffices() -> None:
    """The least single closing lies between a constant that slips and one that does not."""
    trials = [run_holds(HoldTrial("elastic", knob, 5, 0))[0] for knob in np.arange(0.0, 1.7, 0.2)]
    slipping = [one.force for one in trials if one.slipped]
    holding = [one.force for one in trials if not one.slipped]
    friction = 1.15  # what is told of friction may be wrong by so much
    assert max(slipping) / friction < trials[0].oracle < min(holding) * friction


def test_in_the_second_hold_the_forecast_takes_less_force_than_in_the_first() -> None:
    pairs = [run_holds(HoldTrial("forecast", 0.85, material, 0)) for material in range(4)]
    first, second = (np.mean([pair[i].force / pair[i].least for pair in pairs]) for i in (0, 1))
    assert second < 0.95 * first


def test_tightening_by_forecast_holds_where_the_same_force_without_would_slip() -> None:
    once = run_holds(HoldTrial("elastic", 0.4, 2, 0))[0]
    again = run_holds(HoldTrial("forecast, again", 0.9, 2, 0))[0]
    assert once.slipped
    assert not again.slipped
    assert again.tightenings <= 4


def test_the_elastic_rule_tightens_when_the_measured_force_comes_near_the_need() -> None:
    load, rule = Load(1.0, 0.0, 30.0), ElasticAgain(0.1)
    rule.begin(PAD, 0.8, load)
    gripper = Gripper(PAD, np.random.default_rng(1))
    while not gripper.move(rule.is_enough):
        rule.feel(gripper.sense(), -1.0)
    need = rule.need(gripper.pressed.depth)
    assert gripper.pressed.force == pytest.approx((1.0 + GUARD) * 1.1 * need, rel=0.01)
    gripper.closed_at = gripper.time
    while not rule.wants_more():
        rule.feel(gripper.sense(), gripper.time - gripper.closed_at)
        gripper.stand()
    assert gripper.pressed.force == pytest.approx((1.0 + GUARD) * need, rel=0.03)


def test_the_same_trial_gives_the_same_result() -> None:
    trial = HoldTrial("forecast, again", 0.85, 1, 0)
    assert run_holds(trial) == run_holds(trial)


def test_figures_are_means_over_the_holds_and_slips_are_counted() -> None:
    holds = [HoldResult(True, 2, 2.0, 1.0, 3.0, 1.1), HoldResult(False, 0, 3.0, 2.0, 5.0, 2.2)]
    figures = figures_of(holds)
    assert (figures["holds"], figures["slipped"]) == (2, 1)
    assert figures["force_over_least"] == pytest.approx(1.75)
    assert figures["known_over_least"] == pytest.approx(1.1)
    assert figures["tightenings"] == 1.0
    low, high = figures["slip_probability_bounds"]
    assert low < 0.5 < high


def test_every_rule_meets_the_same_pads() -> None:
    trials = trials_of(range(3), 2)
    assert len(trials) == 6 * sum(len(knobs) for knobs in KNOBS.values())
    assert len({(t.material, t.seed) for t in trials}) == 6


def test_the_command_prints_the_fronts_and_draws_them(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {rule: knobs[-1:] for rule, knobs in KNOBS.items()}
    monkeypatch.setattr("validation.controllers.position_hold.study.KNOBS", few)
    path = tmp_path / "fronts.png"
    assert main(["--materials", "1", "--seeds", "1", "--json", "-o", str(path)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert set(told) == {"first hold", "second hold"}
    assert set(told["first hold"]) == set(KNOBS)
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize(
    "wrong", [["--materials", "0"], ["--seeds", "0"], ["--jobs", "0"], ["--first", "-1"]]
)
def test_what_cannot_be_asked_is_refused(wrong: list[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(wrong)
    assert left.value.code == 2
