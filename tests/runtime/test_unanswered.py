"""A process that does not answer is called what it is."""

import os
import signal
import subprocess
import sys

import pytest

from vegrip.runtime import registry


@pytest.fixture
def process():
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    yield child
    child.kill()
    child.wait()
    child.stdin.close()


def test_a_young_process_is_starting(process):
    assert registry.silent_state(process.pid) == "starting"


def test_an_old_one_is_stuck(process, monkeypatch):
    monkeypatch.setattr(registry, "STARTS_WITHIN", 0.0)
    assert registry.silent_state(process.pid) == "stuck"


def test_a_stopped_one_is_stopped_however_young(process):
    process.send_signal(signal.SIGSTOP)
    os.waitpid(process.pid, os.WUNTRACED)
    assert registry.silent_state(process.pid) == "stopped"


def test_one_that_is_not_there_has_ended(process):
    process.kill()
    process.wait()
    assert registry.silent_state(process.pid) == "ended"
