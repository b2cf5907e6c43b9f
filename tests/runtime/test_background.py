"""Helpers of a node have a low priority from the start, end with it, and leave their output."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from vegrip.runtime import background

TOLD = """
import os, sys
print(os.sched_getscheduler(0) == os.SCHED_IDLE, *sys.argv[1:])
print('why', file=sys.stderr)
sys.exit(3)
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Make a module of some text that a new interpreter finds."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    def make(text):
        (tmp_path / "helper.py").write_text(text)
        return "helper"

    return make


def test_a_helper_gives_way_from_its_first_instruction_on_and_leaves_what_it_says(module):
    done = background.run_behind(module(TOLD), ["a", "b c"])
    assert (done.returncode, done.stdout, done.stderr) == (3, "True a b c\n", "why\n")


def test_a_helper_that_takes_too_long_is_ended(module):
    with pytest.raises(subprocess.TimeoutExpired):
        background.run_behind(module("import time; time.sleep(100)"), [], patience=0.3)


def test_a_helper_that_is_waited_for_is_nice(module):
    told = "import os; print(os.nice(0), os.sched_getscheduler(0) == os.SCHED_OTHER)"
    assert background.run_behind(module(told), [], idle=False).stdout == "10 True\n"


def test_without_the_program_that_lowers_it_all_the_way_a_helper_is_nice(module, monkeypatch):
    monkeypatch.setattr(
        background.shutil, "which", lambda name: None if name == "chrt" else f"/usr/bin/{name}"
    )
    done = background.run_behind(module("import os; print(os.nice(0))"), [])
    assert done.stdout == "19\n"


ORPHAN = """
import subprocess, sys, time
helper = subprocess.Popen([sys.executable, "-c", "from vegrip.runtime import launcher; "
    "launcher.end_with_parent(); print('ready', flush=True); import time; time.sleep(100)"],
    stdout=subprocess.PIPE)
helper.stdout.readline()
print(helper.pid, flush=True)
time.sleep(100)
"""


def test_a_helper_ends_when_its_node_is_killed():
    node = subprocess.Popen([sys.executable, "-c", ORPHAN], stdout=subprocess.PIPE, text=True)
    helper = int(node.stdout.readline())
    node.kill()
    node.communicate()
    until = time.monotonic() + 20.0
    while time.monotonic() < until and not _ended(helper):
        time.sleep(0.02)
    assert _ended(helper)


def _ended(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True
