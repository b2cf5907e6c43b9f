"""Measured lifts: what friction orders their outcomes, and what the controller says of them."""

import copy
import json
from collections.abc import Callable
from typing import Any

import pytest

from validation.measured_slip.__main__ import measure, measured_slip, missed
from validation.measured_slip.levels import OUTCOMES, Level, lowest_held, read_levels, tangential_gains
from vegrip.cli import run


@pytest.fixture(scope="module")
def figures() -> dict[str, Any]:
    return measure()


def ordered_share(number: Callable[[Level], float]) -> float:
    """Return how often a lift that was held has a lower ``number`` than one that was not: the AUC."""
    pairs = right = 0.0
    for good in read_levels():
        for bad in read_levels():
            count = good.held * (bad.failed + bad.slid)
            pairs += count
            right += count * (
                1.0 if number(good) < number(bad) else 0.5 if number(good) == number(bad) else 0.0
            )
    return right / pairs


def test_the_lifts_of_the_table_are_those_of_three_of_the_five_masses() -> None:
    counts = {outcome: sum(getattr(level, outcome) for level in read_levels()) for outcome in OUTCOMES}
    assert counts == {"failed": 14, "slid": 11, "held": 17}
    assert {level.mass for level in read_levels()} == {0.25, 0.5, 0.75}
    assert {mass: level.normal_force for mass, level in lowest_held().items()} == {
        "0.250": 4.17, "0.500": 9.41, "0.750": 15.94,
    }  # fmt: skip


def test_friction_that_falls_with_the_load_orders_the_outcomes_and_a_constant_one_does_not() -> None:
    constant = ordered_share(lambda level: level.tangential_force / level.normal_force)
    falling = ordered_share(lambda level: level.tangential_force / level.normal_force**0.75)
    assert constant < 0.9
    assert falling > 0.97


def test_no_lift_that_failed_or_slid_has_a_bound_above_zero(figures: dict[str, Any]) -> None:
    assert figures["failed_with_bound_above_zero"] == 0
    assert figures["with_bound_above_zero"]["slid"] == 0
    assert all(one["bound"] < one["margin"] for one in figures["levels"])


@pytest.mark.parametrize(
    "mass",
    [
        "0.250",
        "0.500",
        "0.750",
    ],
)
def test_what_is_commanded_is_one_to_one_and_a_half_times_what_held(
    figures: dict[str, Any], mass: str
) -> None:
    assert 1.0 <= figures["force_over_lowest_held"][mass] <= 1.6


def test_pads_that_read_low_are_still_commanded_what_held(figures: dict[str, Any]) -> None:
    assert set(figures["force_over_lowest_held_as_read"]) == set(tangential_gains())
    assert all(1.0 <= ratio <= 1.6 for ratio in figures["force_over_lowest_held_as_read"].values())


def test_a_goal_that_is_missed_is_a_sentence(figures: dict[str, Any]) -> None:
    fine = copy.deepcopy(figures)
    fine["force_over_lowest_held"] = dict.fromkeys(fine["force_over_lowest_held"], 1.3)
    assert missed(fine) == []
    fine["failed_with_bound_above_zero"] = 4
    fine["force_over_lowest_held"]["0.500"] = 0.9
    said = missed(fine)
    assert said[0].startswith("4 of 14 grasps that failed")
    assert said[1].startswith("0.90 times the lowest force that held is commanded at 0.500 kg")


def test_the_exit_code_says_whether_the_goals_are_reached(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], figures: dict[str, Any]
) -> None:
    told = copy.deepcopy(figures)
    told["force_over_lowest_held"] = dict.fromkeys(told["force_over_lowest_held"], 1.3)
    monkeypatch.setattr("validation.measured_slip.__main__.measure", lambda: told)
    assert run(measured_slip, ["--json"], "measured_slip") == 0
    assert json.loads(capsys.readouterr().out)["failed_with_bound_above_zero"] == 0
    told["failed_with_bound_above_zero"] = 1
    assert run(measured_slip, [], "measured_slip") == 1
    assert "1 of 14 grasps that failed" in capsys.readouterr().err
