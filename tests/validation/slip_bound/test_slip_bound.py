"""The machinery that judges bounds: a plant that carries a weight, worlds, and how misses are counted."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from validation.slip_bound.__main__ import missed, slip_bound
from validation.slip_bound.forced import LOOKS, Look, play, set_force, stated_bound
from validation.slip_bound.hand import CONFIDENCES, controller
from validation.slip_bound.informed import informed
from validation.slip_bound.pinch import CREEP, Pinch
from validation.slip_bound.run import TAUGHT, WITH, WITHOUT
from validation.slip_bound.shares import figures, missed_goal, most_allowed
from validation.slip_bound.under_grip import DROP, hold
from validation.slip_bound.worlds import (
    EXTREME_ABOVE,
    EXTREME_BELOW,
    WORLDS,
    Grasp,
    draw_grasp,
    friction_class,
)
from vegrip import GripController
from vegrip.cli import run
from vegrip.trials.published_friction import PUBLISHED
from vegrip.web.report.bibtex import references

EVEN = Grasp("", (0.5, 0.5), exponent=0.2, weight=4.0, share=0.5, gain=0.9, force_ratio=1.5, seed=1)
UNEVEN = replace(EVEN, mu=(0.4, 0.6), share=0.64)


def looks_at(margin: float, bounds: dict[float, float], *, slides: bool = False) -> list[Look]:
    return [Look(margin, bounds, math.inf, slides)] * len(LOOKS)


def lifted(grasp: Grasp, force: float, *, falls: bool = False, seconds: float = 1.0) -> Pinch:
    """Return a pinch whose weight came within half a second."""
    pinch = Pinch(grasp, falls=falls)
    for k in range(round(seconds * 200)):
        pinch.step(0.005, force, grasp.weight * min(k / 100.0, 1.0))
    return pinch


@pytest.fixture(scope="module")
def grip() -> GripController:
    return controller(feels_slip=False)


# how misses are counted


def test_a_bound_just_below_the_true_margin_is_never_above_it() -> None:
    margins = np.random.default_rng(1).uniform(0.0, 1.0, 50)
    told = figures([looks_at(one, dict.fromkeys(CONFIDENCES, one - 1e-9)) for one in margins])
    assert set(told["margin_below_bound"].values()) == {0.0}
    assert told["mean_slack"] == pytest.approx(1e-9, rel=1e-3)
    above = figures([looks_at(one, dict.fromkeys(CONFIDENCES, one + 1e-9)) for one in margins])
    assert set(above["margin_below_bound"].values()) == {1.0}


def test_bounds_of_the_right_distribution_are_missed_as_often_as_stated() -> None:
    rng, std, count = np.random.default_rng(2), 0.1, 1000
    errors = std * rng.standard_normal(count)
    told = figures([looks_at(0.5, {c: 0.5 + e - std * norm.ppf(c) for c in CONFIDENCES}) for e in errors])
    for confidence in CONFIDENCES:
        share = told["margin_below_bound"][str(confidence)]
        assert abs(share - (1.0 - confidence)) < 3.0 * math.sqrt(confidence * (1.0 - confidence) / count)
    assert missed_goal(told) == ""


def test_bounds_of_a_distribution_that_is_too_narrow_miss_their_goal() -> None:
    errors = 0.15 * np.random.default_rng(3).standard_normal(700)
    told = figures([looks_at(0.5, {c: 0.5 + e - 0.1 * norm.ppf(c) for c in CONFIDENCES}) for e in errors])
    assert "of 700 grasps, more than" in missed_goal(told)


def test_one_look_of_four_counts_for_the_grasp_and_not_for_its_last_look() -> None:
    fine, wrong = dict.fromkeys(CONFIDENCES, 0.1), dict.fromkeys(CONFIDENCES, 0.3)
    looks = [Look(0.2, wrong, math.inf, slides=False), *looks_at(0.2, fine)[1:]]
    told = figures([looks])
    assert told["margin_below_bound"]["0.95"] == 1.0
    assert told["margin_below_bound_at_the_last_look"]["0.95"] == 0.0


def test_without_a_bound_nothing_is_missed_and_it_is_counted() -> None:
    told = figures([looks_at(0.0, dict.fromkeys(CONFIDENCES, math.nan))])
    assert told["margin_below_bound"]["0.95"] == 0.0
    assert told["looks_without_bound"] == 1.0


def test_a_slide_that_was_not_foretold_is_counted() -> None:
    told = figures([looks_at(0.0, dict.fromkeys(CONFIDENCES, -0.1), slides=True)])
    assert told["slides"] == 1
    assert told["slides_with_earliest_slip_above_zero"] == 1.0


def test_what_is_allowed_is_the_share_and_what_chance_adds() -> None:
    assert most_allowed(700, 0.95) == 45
    assert most_allowed(100_000, 0.95) == pytest.approx(5000, abs=150)
    assert most_allowed(10, 0.5) < 10


# the plant


@pytest.mark.parametrize("grasp", [EVEN, UNEVEN])
def test_the_least_force_is_where_holding_begins(grasp: Grasp) -> None:
    assert lifted(grasp, 1.001 * grasp.least_force).slid == 0.0
    assert lifted(grasp, 0.999 * grasp.least_force).slid > 0.0


def test_both_fingers_carry_the_weight_and_none_more_than_friction_allows() -> None:
    for ratio in (1.01, 1.2, 2.0):
        force = ratio * UNEVEN.least_force
        pinch = lifted(UNEVEN, force)
        limits = UNEVEN.limits(force)
        assert sum(pinch.pulls) == pytest.approx(UNEVEN.weight)
        assert all(pull <= most * (1.0 + 1e-12) for pull, most in zip(pinch.pulls, limits, strict=True))
    assert pinch.pulls[0] == pytest.approx(0.64 * UNEVEN.weight)


def test_a_finger_at_its_limit_has_no_margin_though_the_object_is_held() -> None:
    force = 1.05 * UNEVEN.least_force
    pinch = lifted(UNEVEN, force)
    assert pinch.slid == 0.0
    assert min(pinch.margins(force)) == pytest.approx(0.0, abs=1e-12)


def test_an_object_that_slides_creeps_while_forces_are_set_and_falls_under_the_grip() -> None:
    force = 0.8 * EVEN.least_force
    assert lifted(EVEN, force).slips == (CREEP, CREEP)
    falling = lifted(EVEN, force, falls=True)
    short = 1.0 - sum(EVEN.limits(force)) / EVEN.weight
    assert falling.speed == pytest.approx(9.81 * short * 0.5, rel=0.2)
    caught = falling.slid
    for _ in range(200):
        falling.step(0.005, 3.0 * EVEN.least_force, EVEN.weight)
    assert falling.speed == 0.0
    assert falling.slid > caught


def test_margins_after_a_slide_are_those_of_the_force_that_is_set_then() -> None:
    pinch = lifted(UNEVEN, 0.8 * UNEVEN.least_force)
    assert pinch.margins(0.8 * UNEVEN.least_force) == (0.0, 0.0)
    force = 2.0 * UNEVEN.least_force
    pinch.step(0.005, force, UNEVEN.weight)
    assert sum(pinch.pulls) == pytest.approx(UNEVEN.weight)
    slid, most = UNEVEN.limits(0.8 * UNEVEN.least_force), UNEVEN.limits(force)
    first = slid[0] + UNEVEN.share * (UNEVEN.weight - sum(slid))  # what was missing comes by stiffness
    assert pinch.pulls[0] == pytest.approx(first)
    assert pinch.margins(force)[0] == pytest.approx(1.0 - first / most[0])


# the worlds


@pytest.mark.parametrize("world", list(WORLDS))
def test_a_grasp_is_told_by_its_number(world: str) -> None:
    assert draw_grasp(world, 3) == draw_grasp(world, 3)
    assert draw_grasp(world, 3) != draw_grasp(world, 4)


def test_the_published_world_has_every_row_and_its_extremes_are_a_class() -> None:
    grasps = [draw_grasp("published", seed) for seed in range(700)]
    assert {one.contact for one in grasps} == {row.name for row in PUBLISHED}
    for grasp in grasps:
        is_extreme = not EXTREME_BELOW <= grasp.friction <= EXTREME_ABOVE
        assert (friction_class("published", grasp) == "extreme friction") == is_extreme
        assert 0.6 <= grasp.force_ratio <= 3.0
        assert 0.8 <= grasp.gain <= 1.05
        assert 0.36 <= grasp.share <= 0.64


def test_every_row_has_a_source_that_the_references_list() -> None:
    for row in PUBLISHED:
        assert row.source.strip("[]_") in references(), row.name


def test_the_world_of_the_belief_has_its_moments() -> None:
    grasps = [draw_grasp("belief", seed) for seed in range(2000)]
    logs = np.log([one.mu[0] for one in grasps])
    assert np.mean(logs) == pytest.approx(math.log(0.5), abs=0.03)
    assert np.std(logs) == pytest.approx(0.35, abs=0.03)
    assert np.mean([one.exponent for one in grasps]) == pytest.approx(0.15, abs=0.01)


# grasps


def test_a_force_that_is_set_does_not_follow_the_command(grip: GripController) -> None:
    assert set_force(EVEN, 3.0, taught=False) == pytest.approx(1.5 * EVEN.least_force)
    assert set_force(EVEN, 1.5, taught=True) == pytest.approx(0.8 * EVEN.least_force)
    assert set_force(EVEN, 3.0, taught=True) == pytest.approx(1.5 * EVEN.least_force)
    looks = play(grip, EVEN, feels_slip=False)
    assert [look.margin for look in looks] == pytest.approx([1.0 - 1.5**-0.8] * len(LOOKS), abs=1e-9)


def test_a_bound_is_the_lower_the_more_confident_and_the_stated_one_is_that_of_the_message(
    grip: GripController,
) -> None:
    play(grip, EVEN, feels_slip=False)
    now = round(4.75 * 1e9) + 5_000_000
    bounds = [stated_bound(grip, "thumb", confidence, now) for confidence in CONFIDENCES]
    assert bounds == sorted(bounds, reverse=True)
    assert len(set(bounds)) == len(bounds)
    assert stated_bound(grip, "thumb", 0.95, now) == pytest.approx(grip.margin("thumb").lower_bound)


def test_a_slide_that_is_felt_brings_the_bound_closer_to_the_truth(grip: GripController) -> None:
    feels = controller(feels_slip=True)
    without = play(grip, EVEN, feels_slip=False, taught=True)[-1]
    taught = play(feels, EVEN, feels_slip=True, taught=True)[-1]
    assert taught.margin - taught.bounds[0.95] < 0.5 * (without.margin - without.bounds[0.95])


def test_the_grip_holds_by_its_own_force_what_a_force_that_is_set_lets_slide(grip: GripController) -> None:
    weak = replace(EVEN, force_ratio=0.6)
    assert play(grip, weak, feels_slip=False)[-1].slides
    held = hold(grip, weak, feels_slip=False)
    assert held.slid < DROP
    assert held.force_over_least > 1.0


@pytest.mark.parametrize("world", list(WORLDS))
def test_who_knows_the_world_is_missed_as_often_as_stated(world: str) -> None:
    grasps = [draw_grasp(world, seed) for seed in range(2000)]
    seen = Look(0.25, {}, math.inf, slides=False)
    told = figures([[informed(world, one, seen)] for one in grasps])
    for confidence in CONFIDENCES:
        share = told["margin_below_bound"][str(confidence)]
        std = math.sqrt(confidence * (1.0 - confidence) * (1.0 / 2000 + 1.0 / 10_000))
        assert abs(share - (1.0 - confidence)) < 3.0 * std


def test_who_knows_the_world_says_of_two_objects_that_measure_alike_the_same() -> None:
    slippery, sticky = replace(EVEN, mu=(0.3, 0.3)), replace(EVEN, mu=(0.6, 0.6))
    force = 10.0  # the margins are those of a finger that pulls 2 N
    looks = [
        informed(
            "published", replace(one, force_ratio=force / one.least_force),
            Look(1.0 - 2.0 / one.limits(force)[0], {}, math.inf, slides=False),
        )
        for one in (slippery, sticky)
    ]  # fmt: skip
    assert looks[0].bounds == pytest.approx(looks[1].bounds)
    assert looks[0].margin < looks[1].margin


# the program


def test_the_program_prints_the_figures_of_each_world(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "reliability.png"
    code = run(
        slip_bound,
        ["--json", "--grasps", "2", "--held", "1", "--first", "6", "-o", str(picture)],
        "slip_bound",
    )
    worlds = json.loads(capsys.readouterr().out)["worlds"]
    assert code in (0, 1)
    assert set(worlds) == set(WORLDS)
    for told in worlds.values():
        assert told["grasps"] == 2
        assert set(told["margin_below_bound"]) == {str(one) for one in CONFIDENCES}
        assert {"mean_slack", "slides_per_100", "drops_per_100", "force_over_least", "by_class"} <= set(told)
        assert told["informed"]["grasps"] == 2
    assert picture.stat().st_size > 10_000


def test_a_missed_goal_names_world_and_channel() -> None:
    fine = figures([looks_at(0.5, dict.fromkeys(CONFIDENCES, 0.4))] * 100)
    wrong = figures([looks_at(0.3, dict.fromkeys(CONFIDENCES, 0.4))] * 100)
    assert missed({"published": {**fine, "with_slip_channel": fine, "after_a_slide": fine}}) == []
    said = missed({"published": {**wrong, "with_slip_channel": fine, "after_a_slide": wrong}})
    assert [one.split(":")[0] for one in said] == [f"published world, {one}" for one in (WITHOUT, TAUGHT)]
    assert WITH not in said


def test_a_world_that_is_not_known_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(slip_bound, ["--world", "publishd"], "slip_bound") == 2
    assert "there is no world 'publishd'" in capsys.readouterr().err
