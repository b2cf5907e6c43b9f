"""One number, a slip in so many disturbed seconds, gives the parameters of the grip."""

import logging
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.grip.controller import GripController
from vegrip.grip.joint_confidence import each_confidence
from vegrip.grip.node import GraspForce
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.settings import ControlSettings
from vegrip.grip.slip_table import HAND, MEASURED_WITH, PINCH, derive_grip, describe_derived, probability_for
from vegrip.model import paper_model

NAMES = ("thumb", "index", "middle")
ROWS = ((0.5, 10.0), (0.9, 100.0))


@pytest.mark.parametrize("rows", [PINCH, HAND])
def test_a_surer_grip_slips_more_seldom_in_the_tables(rows: tuple[tuple[float, float], ...]) -> None:
    assert len(rows) >= 3
    assert list(rows) == sorted(rows)
    assert [every for _, every in rows] == sorted(every for _, every in rows)


def test_a_row_gives_its_own_probability_and_beyond_the_rows_the_last_one_counts() -> None:
    for probability, every in ROWS:
        assert probability_for(every, ROWS) == pytest.approx(probability)
    assert probability_for(1.0, ROWS) == 0.5
    assert probability_for(1e6, ROWS) == 0.9


@given(one=st.floats(1.0, 1e4), other=st.floats(1.0, 1e4))
def test_who_wants_fewer_slips_never_gets_a_smaller_probability(one: float, other: float) -> None:
    for rows in (PINCH, HAND, ROWS):
        found = [probability_for(seconds, rows) for seconds in sorted((one, other))]
        assert found == sorted(found)


def test_without_the_number_nothing_changes() -> None:
    grip = GripSettings(probability=0.8)
    assert derive_grip(grip, 5) is grip
    assert describe_derived(grip, 5) == ""


def test_parameters_that_are_set_win_over_those_that_follow() -> None:
    every = PINCH[0][1]
    assert derive_grip(GripSettings(slip_every=every), 2).probability == PINCH[0][0]
    own = derive_grip(GripSettings(slip_every=every, probability=0.99, release_time=2.0), 2)
    assert (own.probability, own.release_time) == (0.99, 2.0)
    assert "probability, release_time as configured" in describe_derived(replace(own), 2)


def test_the_tables_were_measured_with_the_defaults_of_the_package() -> None:
    assert {name: getattr(GripSettings(), name) for name in MEASURED_WITH} == MEASURED_WITH


def test_a_number_that_was_never_measured_is_said_to_be_so() -> None:
    assert "; measured are" in describe_derived(GripSettings(slip_every=1e6), 5)


def test_the_controller_asks_with_the_probability_that_follows_and_a_change_counts_at_once() -> None:
    every = HAND[1][1]
    hand = GripController(NAMES, paper_model(tip_radius=9e-3), settings=with_number(every))
    assert hand.wanted[1] == each_confidence(HAND[1][0], 3, hand.friction.correlation)
    hand.settings = with_number(0.0)
    assert hand.wanted[1] == each_confidence(0.95, 3, hand.friction.correlation)


def test_the_node_logs_which_values_it_took(caplog: pytest.LogCaptureFixture) -> None:
    model = paper_model(tip_radius=9e-3)
    settings = with_number(HAND[1][1])
    node = GraspForce("grip", NAMES, lambda _: ContactEstimator(model, SensorNoise()), settings)
    with caplog.at_level(logging.INFO, logger="vegrip.grip"):
        node.configure()
    assert describe_derived(settings.grip, 3) in [record.getMessage() for record in caplog.records]


def with_number(every: float) -> ControlSettings:
    return ControlSettings(grip=GripSettings(slip_every=every))
