"""States in several classic frames are answered compiled as the messages answer them, to the last byte."""

import os
from dataclasses import replace

import numpy as np
import pytest

from validation.compiled_finger import Answers, Log, Replay, bits_left, differences, hostile, record
from validation.faults.table import CASES, Case
from validation.faults.testbed import Scene
from vegrip.c99 import host
from vegrip.grip.finger import LEFT_ALONE
from vegrip.messages import Condition
from vegrip.model.native import kernel_mode
from vegrip.runtime.hot_path import PART
from vegrip.trials.candidates import demo_parameters

LONG = bool(os.environ.get("VEGRIP_LONG"))
SHORT_CASES = ("normal force stuck at 2 N", "all states of one finger lost for 1 s")
FAULTS = [case for case in CASES if (LONG and not case.slow) or case.name in SHORT_CASES]
EVENTS = 1800


@pytest.fixture(scope="module")
def classic_log() -> Log:
    """Return the frames of five fingers that close, lift and hold, 200 Hz."""
    return record(None, 1.6, "hand", fd=False)


@pytest.fixture(scope="module")
def by_messages(classic_log: Log) -> Answers:
    return Replay(classic_log).run()


def short(log: Log, events: int = EVENTS) -> Log:
    return replace(log, events=log.events[:events])


def test_every_command_of_a_recorded_grasp_is_equal(
    classic_log: Log, by_messages: Answers, mode: str
) -> None:
    compiled = Replay(classic_log, mode).run()
    assert differences(by_messages, compiled) == []
    assert len(compiled.commands) > 1000
    assert {len(data) for _, data in compiled.commands} == {8}
    assert compiled.compiled_frames >= classic_log.frames - 10, "it hardly ran compiled"


@pytest.mark.parametrize("case", FAULTS, ids=[case.name for case in FAULTS])
def test_every_command_under_a_fault_is_equal(case: Case, mode: str) -> None:
    log = record(case, 0.0, fd=False)
    assert differences(Replay(log).run(), Replay(log, mode).run()) == []


@pytest.mark.parametrize("seed", range(30 if LONG else 4))
def test_every_command_to_hostile_frames_is_equal(classic_log: Log, seed: int, mode: str) -> None:
    log = hostile(classic_log, seed)
    messages, compiled = Replay(log).run(), Replay(log, mode).run()
    assert differences(messages, compiled) == []
    assert {"checksum", "counter", "incomplete"} <= set(messages.rejected), "the frames were not hostile"
    assert compiled.compiled_frames > 0.5 * log.frames


def test_hostile_frames_are_refused_for_every_reason(classic_log: Log) -> None:
    seen: set[str] = set()
    for seed in range(4):
        seen |= set(Replay(hostile(classic_log, seed)).run().rejected)
    assert {"checksum", "counter", "incomplete", "length", "value", "version"} <= seen


def test_going_to_and_fro_in_the_middle_of_a_state_changes_nothing(
    classic_log: Log, by_messages: Answers, mode: str
) -> None:
    rng = np.random.default_rng(7)
    replay = Replay(classic_log, mode)
    for event in classic_log.events:
        if rng.random() < 0.2:
            replay.node.leave_lines(str(rng.choice(classic_log.fingers)))
        replay.meet(event)
    answers = replay.finish()
    assert differences(by_messages, answers) == []
    assert answers.compiled_frames > 0.5 * classic_log.frames


def test_forces_beyond_the_frame_are_clipped_and_counted_alike(classic_log: Log, mode: str) -> None:
    base = demo_parameters()
    strong = replace(base, limits=replace(base.limits, min_force=33.0, max_force=60.0, raise_rate=1e3))
    messages = Replay(classic_log, "", strong).run()
    assert differences(messages, Replay(classic_log, mode, strong).run()) == []
    assert messages.clipped["normal_force"] > 100


@pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("seed", [-1, 3])
def test_c_and_plain_python_leave_the_same_bits_in_the_whole_memory(classic_log: Log, seed: int) -> None:
    log = short(classic_log if seed < 0 else hostile(classic_log, seed))
    assert bits_left(Replay(log, "c")) == bits_left(Replay(log, "python"))


@pytest.mark.skipif(kernel_mode() != "numba", reason="numba compiles for a minute; make test-numba")
def test_numba_leaves_the_bits_of_plain_python(classic_log: Log) -> None:
    log = short(hostile(classic_log, 3))
    assert bits_left(Replay(log, "numba")) == bits_left(Replay(log, "python"))


def test_a_frame_that_is_left_alone_has_changed_nothing(classic_log: Log, mode: str) -> None:
    replay = Replay(short(classic_log, 600), mode)
    replay.run()
    frames = [e for e in classic_log.events[600:] if e.frame and replay.lines.get(e.frame.arbitration_id)]
    first = next(i for i, e in enumerate(frames) if e.frame and replay.lines[e.frame.arbitration_id][1] == 1)
    finger = replay.lines[frames[first].frame.arbitration_id][0]  # type: ignore[union-attr]
    parts = [e for e in frames[first:] if e.frame and replay.lines[e.frame.arbitration_id][0] == finger][:3]
    one = replay.node.compiled_fingers[finger]
    one.take_line()
    for number, event in enumerate(parts, 1):
        assert event.frame is not None
        before = (
            one.memory.f.tobytes(),
            one.memory.t.tobytes(),
            replay.node.controller.friction.shared.tobytes(),
        )
        whole = np.frombuffer(event.frame.data, dtype=np.uint8).copy()
        for bit in range(64):
            broken = whole.copy()
            broken[bit // 8] ^= 1 << bit % 8
            assert one.step_part(broken, 8, number, event.frame.stamp, event.now) == LEFT_ALONE
        for length in (0, 7, 9, 48):
            assert one.step_part(whole, length, number, event.frame.stamp, event.now) == LEFT_ALONE
        for other in {1, 2, 3} - {number}:
            assert one.step_part(whole, 8, other, event.frame.stamp, event.now) == LEFT_ALONE
        assert (
            one.memory.f.tobytes(),
            one.memory.t.tobytes(),
            replay.node.controller.friction.shared.tobytes(),
        ) == before
        done = one.step_part(whole, 8, number, event.frame.stamp, event.now)
        assert done & 1 if number == 3 else done == PART
        assert one.step_part(whole, 8, number, event.frame.stamp, event.now) == LEFT_ALONE, "the same twice"


def test_a_hand_on_classic_can_is_held_with_the_same_forces_on_both_ways() -> None:
    compiled, messages = Scene("hand", fd=False), Scene("hand", fd=False)
    messages.grip.endpoint.intercept = None
    for scene in (compiled, messages):
        scene.run_until(1.2)
    path = compiled.grip.runner.hot_path
    assert path is not None
    assert path.frames > 900
    assert compiled.grip.runner.path_taken.startswith("states are answered by the compiled step (")
    assert compiled.course.force == messages.course.force
    assert compiled.course.command == messages.course.command
    assert compiled.course.condition[-1] == (Condition.OK,) * 5
    assert compiled.grip.runner.statistics.states == messages.grip.runner.statistics.states


def test_a_lifetime_that_no_classic_frame_can_carry_is_told_and_answered_alike(
    classic_log: Log, mode: str
) -> None:
    base = demo_parameters()
    lasting = replace(base, limits=replace(base.limits, lifetime=0.6))
    log = short(classic_log, 900)
    replay = Replay(log, mode, lasting)
    assert replay.node.path_taken.endswith("a command lives for 0.6 s (limits.lifetime)")
    assert differences(Replay(log, "", lasting).run(), replay.run()) == []
