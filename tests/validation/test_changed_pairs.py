"""The figures of pairs of recordings: what counts as right, as false and as covered."""

from dataclasses import replace

import numpy as np
import pytest

from validation.changed_pairs import KINDS, MOTIONS, Outcome, Pair, drawn, is_reached, made, summary

NOTHING = Outcome(Pair(0, MOTIONS[0], {}), "nothing", "", True, True, False, False, {})
SOFTER = Outcome(Pair(0, MOTIONS[0], {"K": -0.1}), "named", "", True, True, False, True, {"K": 0.5})


def test_each_kind_is_drawn_with_each_pair_of_motions_and_no_seed_twice() -> None:
    every = list(drawn(len(KINDS) * len(MOTIONS), 1))
    assert {(tuple(one.truth), one.motions) for one in every} >= {
        (kind, two) for kind in KINDS for two in MOTIONS
    }
    assert len({one.seed for one in every}) == len(every)


def test_a_change_is_three_to_twenty_percent() -> None:
    sizes = [abs(np.expm1(one.truth["K"])) for one in drawn(160, 2) if "K" in one.truth]
    assert 0.03 <= min(sizes) < max(sizes) <= 0.2


def test_what_does_not_show_is_no_miss_and_what_is_said_of_nothing_is_false() -> None:
    unseen = replace(SOFTER, is_exact=False, is_right=False, shows=False, errors={})
    told = summary([NOTHING, SOFTER, unseen])
    assert (told["right"], told["right_of_all"], told["false_changes"]) == (1.0, 0.5, 0.0)
    told = summary([replace(NOTHING, verdict="named", is_right=False, is_false=True), SOFTER])
    assert told["false_changes"] == 1.0
    assert not is_reached(told)


@pytest.mark.parametrize(("outside", "reached"), [(5, True), (50, False), (0, False)])
def test_intervals_of_95_percent_hold_neither_too_seldom_nor_always(outside: int, reached: bool) -> None:
    errors = [2.5] * outside + [0.5] * (100 - outside)
    told = summary([NOTHING, *(replace(SOFTER, errors={"K": error}) for error in errors)])
    assert is_reached(told) is reached


@pytest.mark.long
def test_a_gain_scales_what_the_sensor_shows_and_nothing_else() -> None:
    plain = made(Pair(5, ("short", "short"), {}))
    first, second = made(Pair(5, ("short", "short"), {"gain_tangential_force": float(np.log(1.1))}))
    assert np.array_equal(first.columns["normal_force"], plain[0].columns["normal_force"])
    for name, values in second.columns.items():
        by = 1.1 if name.startswith("tangential_force") else 1.0
        np.testing.assert_allclose(values, by * plain[1].columns[name])
