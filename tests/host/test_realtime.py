"""Real-time priority comes with activation where it is permitted, goes with it, and is not inherited."""

import math
import os
import subprocess
import sys
import threading
import time

import pytest

from vegrip.host import realtime
from vegrip.host.realtime import LoopPriority, Permission, Scheduling, choose_scheduling, processor_time
from vegrip.runtime import background

ALL = Permission(99, may_lock=True)


@pytest.mark.parametrize(
    ("wanted", "allowed", "on", "priority", "locks", "says"),
    [
        (10, ALL, True, 10, True, ""),
        (10, ALL, False, 0, False, ""),
        (0, ALL, True, 0, False, ""),
        (0, Permission(0, may_lock=False), True, 0, False, ""),
        (10, Permission(9, may_lock=True), True, 0, False, "real-time priority is not permitted"),
        (10, Permission(0, may_lock=True), False, 0, False, ""),
        (10, Permission(10, may_lock=False), True, 10, False, "locked memory is not permitted"),
    ],
)
def test_a_loop_gets_what_it_wants_permits_and_leaves_on(wanted, allowed, on, priority, locks, says):
    chosen = choose_scheduling(wanted, allowed, on=on)
    assert (chosen.priority, chosen.lock_memory) == (priority, locks)
    assert says in chosen.sentence
    assert bool(chosen.sentence) == bool(says)
    assert not says or ("rtprio" in chosen.sentence and "realtime = false" in chosen.sentence)


def test_the_bus_stands_above_the_node_and_the_node_above_the_hand_and_all_above_side_threads():
    order = (
        realtime.HUB_PRIORITY,
        realtime.NODE_PRIORITY,
        realtime.HAND_PRIORITY,
        realtime.SIDE_THREAD_PRIORITY,
    )
    assert list(order) == sorted(order, reverse=True)
    assert order[-1] > 0


def test_what_is_switched_off_is_so_for_what_is_started_meanwhile_and_on_again_later(monkeypatch):
    monkeypatch.delenv(realtime.SWITCH)
    with realtime.switched(on=False):
        assert not realtime.is_switched_on()
        with realtime.switched(on=True):
            assert not realtime.is_switched_on(), "what is switched off outside stays off"
    assert realtime.is_switched_on()


def test_a_system_that_refuses_leaves_all_as_it_was_and_is_told(monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    priority = LoopPriority(Scheduling(10, lock_memory=True))
    assert "not permitted" in priority.take()
    priority.give_back()
    assert os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER


@pytest.fixture
def permitted():
    """Skip where no program may have a real-time priority."""
    priority = LoopPriority(Scheduling(2))
    sentence = priority.take()
    priority.give_back()
    if sentence:
        pytest.skip("real-time priority is not permitted here")


def policy(thread=0):
    return os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK


@pytest.mark.usefixtures("permitted")
def test_the_loop_has_its_priority_from_take_to_give_back_and_its_threads_a_lower_one():
    over, ids = threading.Event(), []
    beside = threading.Thread(target=lambda: (ids.append(threading.get_native_id()), over.wait()))
    beside.start()
    priority = LoopPriority(Scheduling(3))
    try:
        assert priority.take() == ""
        assert (policy(), os.sched_getparam(0).sched_priority) == (os.SCHED_FIFO, 3)
        assert (policy(ids[0]), os.sched_getparam(ids[0]).sched_priority) == (os.SCHED_FIFO, 1)
    finally:
        priority.give_back()
        over.set()
        beside.join()
    assert policy() == os.SCHED_OTHER


@pytest.mark.usefixtures("permitted")
def test_programs_that_a_loop_starts_have_the_usual_priority():
    priority = LoopPriority(Scheduling(3))
    priority.take()
    try:
        told = subprocess.run(
            [sys.executable, "-c", "import os; print(os.sched_getscheduler(0) == os.SCHED_OTHER)"],
            capture_output=True,
            text=True,
            check=True,
        )
    finally:
        priority.give_back()
    assert told.stdout.strip() == "True"


def of_a_side_task(work):
    """Return what ``work`` returns beside the loop."""
    found = []
    task = realtime.SideTask(lambda: found.append(work()))
    task.start()
    task.join()
    assert not task.is_alive()
    return found[0]


@pytest.mark.usefixtures("permitted")
def test_a_side_task_that_begins_while_a_loop_has_its_priority_has_the_lowest_of_those():
    priority = LoopPriority(Scheduling(3))
    priority.take()
    try:
        during = of_a_side_task(lambda: (policy(), os.sched_getparam(0).sched_priority))
    finally:
        priority.give_back()
    assert during == (os.SCHED_FIFO, realtime.SIDE_THREAD_PRIORITY)
    assert of_a_side_task(policy) == os.SCHED_OTHER


@pytest.mark.usefixtures("permitted")
@pytest.mark.parametrize("found", ["chrt", "nice", ""])
def test_a_helper_that_a_side_task_starts_has_no_priority_over_other_programs(monkeypatch, tmp_path, found):
    (tmp_path / "told_policy.py").write_text("import os; print(os.sched_getscheduler(0))")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    if found == "chrt":  # its policy is that of all it starts; an idle Python takes minutes on a busy machine
        shell = tmp_path / "python"
        shell.write_text("#!/bin/sh\nread -r stat < /proc/self/stat; set -- $stat; echo ${41}\n")
        shell.chmod(0o700)
        monkeypatch.setattr(background.sys, "executable", str(shell))
    which = background.shutil.which
    monkeypatch.setattr(background.shutil, "which", lambda name: which(name) if name == found else None)
    priority = LoopPriority(Scheduling(3))
    priority.take()
    try:
        told = of_a_side_task(lambda: background.run_behind("told_policy", [])).stdout
    finally:
        priority.give_back()
    assert int(told) in (os.SCHED_IDLE, os.SCHED_OTHER)


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="needs /proc")  # noqa: PTH110
def test_it_is_what_the_process_itself_counts() -> None:
    end = time.process_time() + 0.1
    while time.process_time() < end:
        pass
    assert processor_time(os.getpid()) == pytest.approx(time.process_time(), abs=0.03)


def test_it_is_not_known_of_a_process_that_is_not_there() -> None:
    assert math.isnan(processor_time(2**22 + 1))
