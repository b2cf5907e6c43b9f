"""Laws of launching, with processes that are only played."""

import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.clock import NS, SimulatedClock
from vegrip.runtime.launcher import (
    FIRST_DELAY,
    LAST_DELAY,
    STEADY_RUN_S,
    ChildProcess,
    Launcher,
    RestartPolicy,
    Sayings,
)


class Played:
    """A process that ends when told, or at once when asked to."""

    def __init__(self, stage, name, stubborn=False):
        self.stage, self.name, self.stubborn = stage, name, stubborn
        self.code = None

    def poll(self):
        return self.code

    def terminate(self):
        self.stage.log.append(f"terminate {self.name}")
        if not self.stubborn:
            self.code = 0

    def kill(self):
        self.stage.log.append(f"kill {self.name}")
        self.code = -9

    def wait(self, timeout=None):
        if self.code is None:
            raise subprocess.TimeoutExpired(self.name, timeout)
        return self.code


class Stage:
    def __init__(self):
        self.log, self.running, self.clock, self.children = [], {}, SimulatedClock(), []

    def child(self, name, stubborn=False, **options):
        def start():
            self.log.append(f"start {name}")
            self.running[name] = Played(self, name, stubborn)
            return self.running[name]

        self.children.append(ChildProcess(name, start, **options))

    def launcher(self):
        launcher = Launcher(self.children, self.clock, lambda *_: None)
        for child in self.children:
            launcher._start(child)
        return launcher

    def pass_time(self, launcher, seconds):
        end = self.clock.now() + round(seconds * NS)
        while self.clock.now() < end and launcher.step():
            self.clock.advance(0.05)


@pytest.fixture
def stage():
    return Stage()


def test_nodes_start_in_order_and_stop_in_reverse(stage):
    for name in ("a", "b", "c"):
        stage.child(name)
    launcher = stage.launcher()
    launcher.stop_all()
    assert stage.log == ["start a", "start b", "start c", "terminate c", "terminate b", "terminate a"]


def test_who_does_not_end_when_asked_is_killed_before_the_next_is_asked(stage):
    stage.child("a")
    stage.child("b", stubborn=True)
    stage.launcher().stop_all()
    assert stage.log[2:] == ["terminate b", "kill b", "terminate a"]


def test_a_node_that_lost_something_ends_the_launch_with_code_4_also_when_it_was_asked_to_end(stage):
    stage.child("record")
    launcher = stage.launcher()
    recorder = stage.running["record"]
    recorder.terminate = lambda: setattr(recorder, "code", 4)
    launcher.stop_all()
    assert launcher.exit_code == 4


def test_the_end_of_a_required_node_ends_all_with_its_exit_code(stage):
    stage.child("a")
    stage.child("b", required=True)
    launcher = Launcher(stage.children, stage.clock, lambda *_: None)
    stage.clock.sleep_until = lambda _deadline: setattr(stage.running["b"], "code", 3)
    assert launcher.run() == 3
    assert stage.log == ["start a", "start b", "terminate a"]


def test_a_node_that_is_not_required_may_end_and_the_others_go_on(stage):
    stage.child("a")
    stage.child("b")
    launcher = stage.launcher()
    stage.running["b"].code = 0
    stage.pass_time(launcher, 10.0)
    assert stage.running["a"].code is None
    assert stage.log == ["start a", "start b"]


def test_when_all_have_ended_so_has_the_launch(stage):
    stage.child("a")
    launcher = stage.launcher()
    stage.running["a"].code = 0
    assert not launcher.step()
    assert launcher.exit_code == 0


@pytest.mark.parametrize(("code", "expected"), [(0, 0), (3, 3), (-9, 137)])
def test_the_exit_code_tells_how_the_first_ended(stage, code, expected):
    stage.child("a")
    launcher = stage.launcher()
    stage.running["a"].code = code
    launcher.step()
    assert launcher.exit_code == expected


def test_a_failed_node_is_started_again_with_a_growing_delay(stage):
    stage.child("keeper")
    stage.child("a", restart="on-failure")
    launcher = stage.launcher()
    starts = []
    for _ in range(4):
        stage.running["a"].code = 1
        stopped, process = stage.clock.now(), stage.running["a"]
        while stage.running["a"] is process:
            stage.pass_time(launcher, 0.1)
        starts.append((stage.clock.now() - stopped) / NS)
    assert starts == pytest.approx([1.0, 2.0, 4.0, 8.0], abs=0.3)


def said_of_failures(stage, codes, ran=0.1):
    """Let a node end again and again; return what the launcher says of it."""
    said = []
    stage.child("a", restart="always")
    launcher = Launcher(stage.children, stage.clock, lambda _, sentence: said.append(sentence))
    launcher._start(stage.children[0])
    for code in codes:
        process = stage.running["a"]
        stage.pass_time(launcher, ran)
        process.code = code
        while stage.running["a"] is process:
            stage.pass_time(launcher, 0.1)
    return said


def test_a_node_that_cannot_start_is_said_once_and_then_with_how_often_and_ever_less(stage):
    said = said_of_failures(stage, [4] * 9)
    assert said == [
        "started",
        "ended with exit code 4; starts again in 1 s",
        "ended with exit code 4, 2 times in a row; starts again in 2 s",
        "ended with exit code 4, 4 times in a row; starts again in 8 s",
        "ended with exit code 4, 8 times in a row; starts again in 30 s",
    ]


@pytest.mark.parametrize(("code", "ran"), [(-9, 0.1), (0, 0.1), (4, STEADY_RUN_S + 1.0)])
def test_each_end_of_a_node_that_had_worked_is_said_and_each_start(stage, code, ran):
    said = said_of_failures(stage, [code] * 3, ran)
    assert [one.split()[0] for one in said] == ["started", "ended"] * 3 + ["started"]


def test_a_sentence_of_a_row_of_failures_is_new_once_and_another_one_is_new():
    sayings = Sayings()
    found = []
    for again, line in ((False, "gone"), (True, "gone"), (True, "busy"), (True, "busy"), (False, "busy")):
        sayings.begin(again=again)
        found.append(sayings.is_new(line))
    assert found == [True, False, True, False, True]


def test_a_node_waiting_for_its_restart_is_not_started_by_the_stop(stage):
    stage.child("a", restart="always")
    launcher = stage.launcher()
    stage.running["a"].code = 1
    launcher.step()
    launcher.stop_all()
    stage.clock.advance(100.0)
    launcher.step()
    assert stage.log == ["start a"]


@given(st.integers(-15, 255), st.floats(0.0, 1e4))
def test_the_policy_does_what_its_name_says(code, ran):
    assert RestartPolicy("never").delay(code, ran) is None
    assert RestartPolicy("always").delay(code, ran) is not None
    assert (RestartPolicy("on-failure").delay(code, ran) is None) == (code == 0)


@given(st.lists(st.floats(0.0, 2 * STEADY_RUN_S), min_size=1, max_size=20))
def test_the_delay_stays_within_its_limits_and_a_steady_run_resets_it(runs):
    policy = RestartPolicy("always")
    for ran in runs:
        delay = policy.delay(1, ran)
        assert FIRST_DELAY <= delay <= LAST_DELAY
        if ran >= STEADY_RUN_S:
            assert delay == FIRST_DELAY


def test_the_next_child_waits_until_the_one_before_is_ready():
    stage = Stage()
    asked = []

    def ready():
        asked.append(stage.clock.now())
        return len(asked) > 5

    stage.child("first", ready=ready)
    stage.child("second")
    launcher = Launcher(stage.children, stage.clock, lambda *_: None)
    assert launcher._brought_up(stage.children[0])
    assert stage.log == ["start first"]
    assert len(asked) == 6
    assert len(set(asked)) == 6


def test_nothing_more_is_started_when_a_required_child_ends_before_it_is_ready():
    stage = Stage()
    stage.child("first", required=True, ready=lambda: False)
    stage.child("second")
    start = stage.children[0].start

    def fail():
        process = start()
        process.code = 3
        return process

    stage.children[0].start = fail
    assert Launcher(stage.children, stage.clock, lambda *_: None).run() == 3
    assert "start second" not in stage.log
