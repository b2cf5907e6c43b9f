"""Helpers of a node have a low priority from the start, end with it, and leave their output."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from vegrip.runtime import background

TOLD = """
import os, sys
print(os.nice(0), os.sched_getscheduler(0) == os.SCHED_OTHER, *sys.argv[1:])
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


def test_a_helper_that_is_waited_for_is_nice_and_leaves_what_it_says(module):
    own = os.nice(0)  # of whoever runs the tests
    done = background.run_behind(module(TOLD), ["a", "b c"], idle=False)
    assert (done.returncode, done.stderr) == (3, "why\n")
    assert done.stdout == f"{min(own + 10, 19)} True a b c\n"


@pytest.mark.skipif(shutil.which("chrt") is None, reason="no chrt")
def test_a_helper_gives_way_from_its_first_instruction_on(module, tmp_path, monkeypatch):
    """A shell tells the policy, that of all it starts: an idle Python takes minutes beside others."""
    shell = tmp_path / "python"
    shell.write_text("#!/bin/sh\nread -r stat < /proc/self/stat; set -- $stat; echo ${41}\n")
    shell.chmod(0o700)
    monkeypatch.setattr(background.sys, "executable", str(shell))
    assert int(background.run_behind(module(""), []).stdout) == os.SCHED_IDLE


def test_a_helper_that_takes_too_long_is_ended(module):
    with pytest.raises(subprocess.TimeoutExpired):
        background.run_behind(module("import time; time.sleep(100)"), [], patience=0.3)


def test_without_the_program_that_lowers_it_all_the_way_a_helper_is_nice(module, monkeypatch):
    monkeypatch.setattr(
        background.shutil, "which", lambda name: None if name == "chrt" else f"/usr/bin/{name}"
    )
    done = background.run_behind(module("import os; print(os.nice(0))"), [])
    assert done.stdout == "19\n"


IMPORTS = """
import os, sys, time
open(sys.argv[1], "w").write(str(os.getpid()))
time.sleep(60)  # the imports of a helper, which has not come to its own first line
open(sys.argv[1] + ".lived on", "w").close()
"""


def test_a_helper_ends_when_its_node_is_killed_whatever_it_is_doing(module, tmp_path):
    told = tmp_path / "pid"
    node = subprocess.Popen(
        [sys.executable, "-c", f"from vegrip.runtime.background import run_behind; "
         f"run_behind({module(IMPORTS)!r}, [{str(told)!r}], idle=False)"]
    )  # fmt: skip
    while not (told.exists() and told.read_text()):
        assert node.poll() is None
        time.sleep(0.02)
    helper = int(told.read_text())
    node.kill()
    node.communicate()
    while not _ended(helper):  # by itself it ends after a minute, and leaves a file
        time.sleep(0.02)
    assert not told.with_name("pid.lived on").exists()


def test_a_helper_whose_node_has_ended_already_does_not_begin(module):
    done = subprocess.run(
        [sys.executable, "-m", "vegrip.runtime.background", "1", module("print('began')")],
        capture_output=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (-signal.SIGTERM, b"")


def _ended(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True
