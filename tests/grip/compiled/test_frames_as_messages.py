"""A frame is answered as the message that it carries, to the last byte."""

import os
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from validation.compiled_finger import Answers, Log, Replay, differences, hostile, record
from validation.faults.table import CASES, Case
from vegrip.grip.parameters import GraspParameters
from vegrip.trials.candidates import demo_parameters

LONG = bool(os.environ.get("VEGRIP_LONG"))
SHORT_CASES = ("normal force stuck at 2 N", "all states of one finger lost for 1 s")
FAULTS = [case for case in CASES if (LONG and not case.slow) or case.name in SHORT_CASES]
SEEDS = range(40 if LONG else 2)


@pytest.fixture(scope="session")
def as_messages(hand_log: Log) -> Answers:
    """Return what is answered to the messages."""
    return Replay(hand_log).run()


@pytest.mark.parametrize("policy", ["constant", "cone", "elastic"])
def test_the_baseline_policies_run_compiled(hand_log: Log, policy: str, mode: str) -> None:
    parameters = replace(demo_parameters(), policy=policy)
    compiled = Replay(hand_log, mode, parameters).run()
    assert compiled.compiled_frames >= hand_log.frames - 10
    assert differences(Replay(hand_log, "", parameters).run(), compiled) == []


def test_every_command_of_a_recorded_grasp_is_equal(hand_log: Log, as_messages: Answers, mode: str) -> None:
    compiled = Replay(hand_log, mode).run()
    assert differences(as_messages, compiled) == []
    assert len(compiled.commands) > 1000
    assert compiled.compiled_frames >= hand_log.frames - 10, "it hardly ran compiled"
    assert compiled.packed_reports > 0.9 * len(as_messages.reports), "reports were hardly packed by it"


@pytest.mark.parametrize("case", FAULTS, ids=[case.name for case in FAULTS])
def test_every_command_under_a_fault_is_equal(case: Case, mode: str) -> None:
    log = record(case, 0.0)
    assert differences(Replay(log).run(), Replay(log, mode).run()) == []


@pytest.mark.parametrize("seed", SEEDS)
def test_every_command_to_hostile_states_is_equal(hand_log: Log, seed: int, mode: str) -> None:
    log = hostile(replace(hand_log, sender_time=seed % 2 == 0), seed)
    messages, compiled = Replay(log).run(), Replay(log, mode).run()
    assert differences(messages, compiled) == []
    assert sum(sum(faults.values()) for faults in messages.faults.values()) > 8, "the states were not hostile"


def test_hostile_states_go_through_most_conditions(hand_log: Log) -> None:
    seen = {
        condition
        for seed in range(6)
        for conditions in Replay(hostile(hand_log, seed)).run().conditions
        for condition in conditions
    }
    assert len(seen) >= 7, seen


def to_and_fro(log: Log, mode: str) -> Answers:
    """Return what is answered where a finger now and then goes back to messages."""
    rng, replay = np.random.default_rng(7), Replay(log, mode)
    for event in log.events:
        if rng.random() < 0.2:
            replay.node.leave_lines(str(rng.choice(log.fingers)))
        replay.meet(event)
    return replay.finish()


def test_going_to_and_fro_between_both_ways_changes_nothing(
    hand_log: Log, as_messages: Answers, mode: str
) -> None:
    assert differences(as_messages, to_and_fro(hand_log, mode)) == []


def changed_on_the_way(log: Log, mode: str, change: Callable[[GraspParameters], GraspParameters]) -> Answers:
    """Return what is answered where parameters are changed in the middle."""
    replay = Replay(log, mode)
    for number, event in enumerate(log.events):
        if number == len(log.events) // 2:
            given: GraspParameters = replay.node.parameters  # type: ignore[assignment]
            replay.node.parameters = change(given)
        replay.meet(event)
    return replay.finish()


def test_parameters_changed_on_the_way_count_at_once_on_both_ways(
    hand_log: Log, as_messages: Answers, mode: str
) -> None:
    def with_other_rules(given: GraspParameters) -> GraspParameters:
        limits = replace(given.limits, min_force=1.0, lower_rate=3.0)
        grip = replace(given.grip, wanted_margin=0.3, release_time=0.4)
        return replace(given, limits=limits, grip=grip, watchdog=replace(given.watchdog, time_out=0.004))

    messages = changed_on_the_way(hand_log, "", with_other_rules)
    assert differences(messages, changed_on_the_way(hand_log, mode, with_other_rules)) == []
    assert messages.commands != as_messages.commands


def test_where_python_takes_part_frames_are_decoded(hand_log: Log, mode: str) -> None:
    contacts = {"thumb": {"normal": [0.0, 0.0, 1.0]}, "index": {"normal": [0.0, 0.0, -1.0]}}
    parameters = replace(demo_parameters(), contacts=contacts)
    compiled = Replay(hand_log, mode, parameters).run()
    assert compiled.compiled_frames == 0
    assert differences(Replay(hand_log, "", parameters).run(), compiled) == []


@pytest.fixture(scope="module")
def learning_log() -> Log:
    """Return what a hand meets whose fingers share friction and probe for it, with loads led."""
    return record(None, 4.0, "hand", "learning")


@pytest.fixture(scope="module")
def learning_begins(learning_log: Log) -> Log:
    return replace(learning_log, events=learning_log.events[: len(learning_log.events) // 2])


@pytest.fixture(scope="module")
def learning_messages(learning_log: Log) -> Answers:
    return Replay(learning_log).run()


def test_every_command_is_equal_where_friction_is_shared_and_probed(
    learning_log: Log, learning_messages: Answers, mode: str
) -> None:
    replay = Replay(learning_log, mode)
    compiled = replay.run()
    assert differences(learning_messages, compiled) == []
    assert compiled.compiled_frames >= learning_log.frames - 20, "it hardly ran compiled"
    assert replay.node.controller is not None
    assert replay.node.controller.friction.belief("thumb")[1] < 0.35, "nothing was learned"


@pytest.mark.parametrize("seed", range(12 if LONG else 2))
def test_every_command_to_hostile_states_is_equal_where_friction_is_shared(
    learning_log: Log, seed: int, mode: str
) -> None:
    log = hostile(learning_log, seed)
    assert differences(Replay(log).run(), Replay(log, mode).run()) == []


def test_going_to_and_fro_changes_nothing_where_friction_is_shared(
    learning_log: Log, learning_messages: Answers, mode: str
) -> None:
    assert differences(learning_messages, to_and_fro(learning_log, mode)) == []


@pytest.mark.parametrize(
    ("friction", "grip"),
    [
        ({"learning": True}, {}),
        ({"learning": True, "slip_delay": 0.05}, {}),
        ({"learning": True, "sliding_speed": 0.0}, {}),
        ({}, {"drive_lag": 0.02}),
        ({"learning": True}, {"proven_time": 3.0, "usual_time": 0.5}),
    ],
    ids=str,
)
def test_each_part_of_learning_is_equal_by_itself(
    friction: dict[str, object], grip: dict[str, float], learning_begins: Log, mode: str
) -> None:
    base = demo_parameters()
    parameters = replace(
        base,
        friction=replace(base.friction, **friction),  # type: ignore[arg-type]
        grip=replace(base.grip, **grip),  # type: ignore[arg-type]
    )
    compiled = Replay(learning_begins, mode, parameters).run()
    assert compiled.compiled_frames >= learning_begins.frames - 20
    assert differences(Replay(learning_begins, "", parameters).run(), compiled) == []


def test_lag_and_proven_time_changed_on_the_way_count_at_once_on_both_ways(
    learning_log: Log, learning_messages: Answers, mode: str
) -> None:
    def with_lag(given: GraspParameters) -> GraspParameters:
        grip = replace(given.grip, drive_lag=0.03, proven_time=1.0, known_probability=0.9)
        return replace(given, grip=grip)

    messages = changed_on_the_way(learning_log, "", with_lag)
    assert differences(messages, changed_on_the_way(learning_log, mode, with_lag)) == []
    assert messages.commands != learning_messages.commands


@pytest.mark.other_model
def test_a_surface_and_settings_of_another_kind_are_equal(hand_log: Log, mode: str) -> None:
    base = demo_parameters()
    other = replace(
        base,
        thumb="",
        estimator=replace(base.estimator, surface="ellipse", late=0, hold="position"),
        grip=replace(base.grip, usual_time=0.0, probability=0.99),
    )
    compiled = Replay(hand_log, mode, other).run()
    assert compiled.compiled_frames > 1000
    assert differences(Replay(hand_log, "", other).run(), compiled) == []
