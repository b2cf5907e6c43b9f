"""Laws of the registry of running nodes."""

import os
import signal
import socket
import subprocess
import sys

import pytest

from vegrip.errors import ConfigError, UsageError
from vegrip.host.folders import runtime_folder
from vegrip.runtime import registry
from vegrip.runtime.launch_file import full_name
from vegrip.runtime.registry import (
    KEPT_S,
    Entry,
    ExitReport,
    find_node,
    read_reports,
    registered,
    running_nodes,
    write_report,
)

pytestmark = pytest.mark.usefixtures("runtime")


def test_a_node_is_known_while_it_lives_and_not_longer():
    entry = Entry("/left/grip", "echo", "left", {"/a": "/b"}, os.getpid())
    with registered(entry):
        assert running_nodes() == [entry]
    assert running_nodes() == []
    assert list(runtime_folder("nodes").iterdir()) == []


def test_two_nodes_of_one_name_are_refused_two_namespaces_are_not():
    with registered(Entry("/left/grip", "echo")), registered(Entry("/right/grip", "echo")):
        with pytest.raises(UsageError, match="runs already"), registered(Entry("/left/grip", "echo")):
            pass
        assert len(running_nodes()) == 2


def test_a_node_that_was_killed_is_forgotten():
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        with registered(Entry("/grip", "echo")):
            os.write(writer, b"x")
            signal.pause()
    os.read(reader, 1)
    assert [entry.name for entry in running_nodes()] == ["/grip"]
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    assert running_nodes() == []
    assert read_reports()["/grip"].reason == "its process was killed, or crashed"
    os.close(reader)
    os.close(writer)


def test_a_report_of_a_failure_is_shown_for_some_minutes_and_until_the_node_runs_again():
    for name in ("/grip", "/replay"):
        write_report(ExitReport(name, "echo", "it could not", 3))
    file = runtime_folder("nodes") / "replay.end"
    long_ago = file.stat().st_mtime - 1.1 * KEPT_S
    os.utime(file, (long_ago, long_ago))
    assert list(read_reports()) == ["/grip"]
    assert not file.exists()
    with registered(Entry("/grip", "echo")):
        assert read_reports() == {}


def test_a_node_is_found_by_its_last_name_unless_two_have_it():
    left, right = Entry("/left/grip", "echo"), Entry("/right/grip", "echo")
    with registered(left):
        assert find_node("grip") == find_node("/left/grip") == find_node("left/grip") == left
        with registered(right):
            assert find_node("/right/grip") == right
            with pytest.raises(UsageError, match="several"):
                find_node("grip")
        with pytest.raises(UsageError, match="running: /left/grip"):
            find_node("nobody")


def test_a_broken_file_is_not_a_node():
    (runtime_folder("nodes") / "x.node").write_text("not json")
    assert running_nodes() == []


@pytest.mark.parametrize("name", ["", "a b", "a/b", "../x", "1st"])
def test_what_is_no_name_is_refused(name):
    with pytest.raises(ConfigError):
        full_name("", name)


def test_the_full_name_has_the_namespace():
    assert full_name("lab/left", "grip") == full_name("/lab/left/", "grip") == "/lab/left/grip"


def test_the_sockets_of_a_node_that_was_killed_go_with_it():
    entry = Entry("/grip", "echo")
    child = os.fork()
    if child == 0:
        with registered(entry):
            for address in (entry.control, entry.telemetry):
                socket.socket(socket.AF_UNIX).bind(address.removeprefix("ipc://"))
            os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    assert len(list(runtime_folder("nodes").iterdir())) == 3
    with registered(Entry("/another", "echo")):  # the next node that starts sees to it
        assert {path.name for path in runtime_folder("nodes").iterdir()} == {"another.node", "grip.end"}


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
