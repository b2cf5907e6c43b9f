"""Laws of a node in a process of its own."""

import logging
import signal

import pytest

from vegrip.errors import DeviceError, VegripError
from vegrip.host import descriptors
from vegrip.host.folders import runtime_folder
from vegrip.messages import Lifecycle
from vegrip.runtime import NodeBase, process
from vegrip.runtime.launch_file import NodeConfig
from vegrip.runtime.process import OncePerSecond, node_logs
from vegrip.runtime.registry import read_reports


class Broken(NodeBase):
    def configure(self):
        raise ZeroDivisionError("somebody's own effect\nin many lines")


@pytest.mark.usefixtures("runtime")
def test_whatever_a_node_raises_at_its_start_is_one_sentence(monkeypatch):
    monkeypatch.setattr(process, "find_program", lambda _: lambda *_: Broken("broken"))
    transport = {"kind": "can", "channel": "broken"}
    config = NodeConfig(program="broken", name="broken", fingers=("thumb",), transport=transport)
    with pytest.raises(
        VegripError, match=r"broken cannot be started: ZeroDivisionError: somebody's own effect$"
    ):
        process.run_node(config)
    assert "somebody's own effect" in read_reports()["/broken"].reason


@pytest.mark.usefixtures("runtime")
def test_a_node_that_may_open_too_few_files_does_not_start(monkeypatch):
    monkeypatch.setattr(descriptors, "limit", lambda: 300)
    monkeypatch.setattr(descriptors.resource, "setrlimit", lambda *_: None)
    config = NodeConfig(program="echo", name="echo", fingers=("thumb",), transport={"kind": "can"})
    with pytest.raises(DeviceError, match="only 300 files may be open"):
        process.run_node(config)


class Lossy(NodeBase):
    def cleanup(self):
        self.failure = "the recording x is not whole: 3 of 4 rows are lost (deleted)"

    def activate(self):
        self.finished = True


@pytest.mark.usefixtures("runtime")
def test_a_node_that_lost_what_it_was_given_ends_with_a_sentence_and_code_4(monkeypatch):
    monkeypatch.setattr(process, "find_program", lambda _: lambda *_: Lossy("lossy"))
    transport = {"kind": "can", "channel": "lossy"}
    config = NodeConfig(program="lossy", name="lossy", fingers=("thumb",), transport=transport)
    with pytest.raises(DeviceError, match="3 of 4 rows are lost"):
        process.run_node(config)
    assert read_reports()["/lossy"].exit_code == 4


class Running:
    """A runner in some state."""

    def __init__(self, running, state):
        self.running, self.state, self.stopped = running, state, 0

    def stop(self):
        self.stopped += 1


def test_a_signal_lets_the_loop_end_and_further_ones_change_nothing():
    ending = process.Ending()
    ending.runner = Running(True, Lifecycle.ACTIVE)
    for _ in range(7):  # as a launcher with seven threads has the kernel send them
        ending()
    assert ending.runner.stopped == 7
    ending.begin()
    ending.runner = None
    ending()


def test_before_the_loop_a_burst_of_signals_interrupts_once():
    ending = process.Ending()
    ending.runner = Running(False, Lifecycle.UNCONFIGURED)
    with pytest.raises(KeyboardInterrupt):
        ending()
    ending()


@pytest.mark.usefixtures("runtime")
def test_sigterm_is_ignored_once_it_has_ended_a_node(monkeypatch):
    monkeypatch.setattr(process, "find_program", lambda _: lambda *_: Interrupted("interrupted"))
    transport = {"kind": "can", "channel": "interrupted"}
    config = NodeConfig(program="i", name="interrupted", fingers=("thumb",), transport=transport)
    before = signal.getsignal(signal.SIGTERM)
    try:
        process.run_node(config)
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)
    assert [path.name for path in runtime_folder("nodes").iterdir()] == []


class Interrupted(NodeBase):
    """Gets the death signal of its launcher while it runs, and again while it is tidied up."""

    def activate(self):
        signal.raise_signal(signal.SIGTERM)

    def cleanup(self):
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)


def record(line, text="x", level=logging.WARNING):
    return logging.LogRecord("vegrip", level, "file.py", line, text, None, None)


def test_a_source_line_speaks_a_little_more_than_once_a_second_and_tells_how_often_it_would_have():
    now = [0.0]
    limit = OncePerSecond(lambda: now[0])
    let_through = []
    for i in range(2500):
        now[0] = i * 0.001
        entry = record(1)
        if limit.filter(entry):
            let_through.append((now[0], entry.msg))
    assert [time for time, _ in let_through] == [0.0, 0.9, 1.8]
    assert "899 more" in let_through[1][1]


def test_source_lines_do_not_silence_each_other():
    limit = OncePerSecond(lambda: 5.0)
    assert [limit.filter(record(line)) for line in (1, 2, 1, 3)] == [True, True, False, True]
    assert limit.filter(record(1, level=logging.ERROR))  # nor levels


def test_logs_bear_the_name_of_the_node_and_handlers_are_taken_away_again(capsys):
    before = list(logging.getLogger().handlers)
    with node_logs("/left/grip"):
        logging.getLogger("vegrip.x").info("hello")
    assert "INFO /left/grip: hello" in capsys.readouterr().err
    assert logging.getLogger().handlers == before
