"""When a finger tells what it has learned: at once, then every period, apart from the other fingers."""

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import pytest

from vegrip.estimator.learning import Learned
from vegrip.grip.finger_reports import FingerReports
from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.messages import (
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    LearnedParameter,
    ModelHealth,
    SlipMargin,
)

MakeNode = Callable[..., GraspForce]
MakeState = Callable[..., FingertipState]
MS = 1_000_000  # [ns]
PERIOD = 2 * MS
LEARNED = {"K": Learned(Estimate(2.0, 0.1, True, 0.0), 1.9, valid=True, excited=3.0)}


def told(reports: FingerReports, times: list[int]) -> list[int]:
    """Return when something is told, looked at at these times [ms]."""
    return [time for time in times if list(reports.learned(LEARNED, time * MS))]


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.8])
def test_what_is_learned_is_told_at_once_and_then_every_second_by_a_share_of_it_apart(phase: float) -> None:
    reports = FingerReports(SimpleNamespace(name="thumb"), ControlSettings(), phase)  # type: ignore[arg-type]
    second = 40 + round(1000 * (1.0 - phase))
    assert told(reports, list(range(40, 2900, 10))) == [40, *range(second, 2900, 1000)]


@pytest.mark.parametrize(("raw_is_valid", "is_valid"), [(True, False), (False, True)])
def test_what_is_filtered_is_told_with_spread_and_age_of_the_raw_value_and_a_validity_of_its_own(
    raw_is_valid: bool, is_valid: bool
) -> None:
    raw = Estimate(2.0, 0.1, raw_is_valid, 0.7)
    learned = {"K": Learned(raw, 1.9, valid=is_valid, excited=3.0), "p": LEARNED["K"]}
    reports = FingerReports(SimpleNamespace(name="thumb"), ControlSettings(), 0.0)  # type: ignore[arg-type]
    first, second = reports.learned(learned, 40 * MS)
    filtered = Estimate(1.9, 0.1, is_valid, 0.7)
    assert first == LearnedParameter(40 * MS, "thumb", 0, "K", raw, filtered, 3.0)
    assert isinstance(second, LearnedParameter)
    assert (second.seq, second.symbol) == (1, "p")


def test_a_clock_that_was_set_back_does_not_silence_what_is_learned() -> None:
    reports = FingerReports(SimpleNamespace(name="thumb"), ControlSettings(), 0.0)  # type: ignore[arg-type]
    assert told(reports, [5000, 5500, 100, 600, 1100]) == [5000, 100, 1100]


def test_whether_something_is_due_is_known_beforehand_to_the_nanosecond(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()
    controller, reports = node.controller, node.fingers["index"].reports
    found = {True: 0, False: 0}
    for i in range(1, 400):
        controller.answer(state(i, normal_force=1e3 if i in (200, 201) else 3.0), i * PERIOD)
        for now in (i * PERIOD, i * PERIOD + 1, (i + 1) * PERIOD - 1):
            is_due = reports.are_due(now)
            assert is_due == bool(list(reports.due(now))) or i < 5
            found[is_due] += 1
    assert min(found.values()) > 30


@pytest.mark.parametrize(("before", "after"), [(1.0, 0.02), (0.02, 0.3), (0.5, 0.5)])
def test_another_period_counts_from_the_last_report_on(
    make_node: MakeNode, state: MakeState, before: float, after: float
) -> None:
    node = make_node(settings=ControlSettings(report_period=before))
    told = []
    for i in range(1, 500):
        if i == 100:
            node.parameters = replace(node.parameters, report_period=after)
        told += [i for m in node.on_message(state(i), i * PERIOD) if isinstance(m, SlipMargin)]
    last = max(i for i in told if i < 100)
    assert min(i for i in told if i >= 100) == max(last + after / 2e-3, 100)


def test_after_a_clock_was_set_back_contact_and_health_are_told_at_once(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node()
    for i in range(5000, 5050):
        list(node.on_message(state(i), i * PERIOD))
    told = list(node.fingers["index"].reports.due(4000 * PERIOD))
    assert [type(one) for one in told] == [ContactEstimate, SlipMargin, ModelHealth]
    assert list(node.fingers["index"].reports.due(4000 * PERIOD + 10 * MS)) == []


def test_of_a_silent_finger_nothing_is_known_but_how_old_it_is(make_node: MakeNode, state: MakeState) -> None:
    node = make_node()
    reports = node.fingers["index"].reports
    for i in range(1, 100):
        list(node.on_message(state(i), i * PERIOD))
    told = replace(
        node.fingers["index"].estimator.slip_margin(), force_reserve=1.0, time_to_slip=2.0, earliest_slip=0.5
    )
    node.fingers["index"].estimator.slip_margin = lambda: told  # type: ignore[method-assign]
    known, margin = reports.contact(99 * PERIOD), reports.margin(99 * PERIOD)
    list(node.on_tick(99 * PERIOD + 80 * MS))
    assert node.fingers["index"].condition is Condition.STALE
    for at, age in ((80 * MS, 0.08), (1080 * MS, 1.08), (-MS, 0.0)):
        now = 99 * PERIOD + at
        vague = replace(known.normal_force, std=math.inf, valid=False, age=pytest.approx(age))
        assert reports.contact(now).normal_force == vague
        assert reports.margin(now).margin == replace(margin.margin, std=math.inf, valid=False, age=vague.age)
        silent = reports.margin(now)
        unknown = (silent.lower_bound, silent.force_reserve, silent.time_to_slip, silent.earliest_slip)
        assert all(math.isnan(one) for one in unknown)
