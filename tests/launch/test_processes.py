"""Nodes as real processes: started, asked, changed, restarted and stopped."""

import json
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from vegrip.cli import main
from vegrip.host.folders import runtime_folder
from vegrip.transport.canbus.virtual_can import hub_process

LAUNCH = """
[transport]
channel = "launch"

[[node]]
program = "echo"
name = "first"

[[node]]
program = "echo"
name = "second"
restart = "on-failure"
"""
PATIENCE = 180.0  # [s] of a machine that does much else
pytestmark = pytest.mark.usefixtures("runtime")


@pytest.fixture
def vegrip(capsys):
    """Run a command in this process; give its exit code and what it says."""

    def run(*arguments):
        code, told = main(list(arguments)), capsys.readouterr()
        return code, told.out, told.err

    return run


def start(*arguments):
    command = [sys.executable, "-m", "vegrip", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def wait_for(condition):
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if (found := condition()) is not None:
            return found
        time.sleep(0.1)
    raise AssertionError("did not happen in time")


def states():
    from vegrip.errors import VegripError
    from vegrip.runtime.registry import ask, running_nodes

    try:
        return {
            entry.name: (entry.pid, ask(entry, "state", patience=1.0)["state"]) for entry in running_nodes()
        }
    except VegripError:
        return {}


def both_active():
    now = states()
    return now if [state for _, state in now.values()] == ["active"] * 2 else None


@pytest.mark.long
@pytest.mark.slow
def test_a_launch_starts_watches_restarts_and_stops_in_reverse(tmp_path, vegrip):
    path = tmp_path / "two.toml"
    path.write_text(LAUNCH)
    launched = start("launch", str(path))
    try:
        before = wait_for(both_active)
        os.kill(before["/second"][0], signal.SIGKILL)
        after = wait_for(lambda: now if (now := both_active()) and now != before else None)
        assert after["/first"] == before["/first"]

        assert vegrip("param", "set", "first", "normal_force", "2.5")[0] == 0
        assert json.loads(vegrip("param", "get", "first", "normal_force", "--json")[1])["value"] == 2.5
        code, _, complaint = vegrip("param", "set", "first", "normal_force", "-1")
        assert (code, "0 .. 20 N" in complaint) == (3, True)
        assert vegrip("lifecycle", "set", "second", "inactive")[1].strip() == "inactive"
        topics = json.loads(vegrip("topic", "list", "--json")[1])
        assert topics["/diagnostics"]["from"] == ["/first", "/second"]
        assert json.loads(vegrip("lifecycle", "status", "first", "--json")[1])["state"] == "active"
        echoed = json.loads(vegrip("topic", "echo", "/diagnostics", "--count", "1", "--json")[1])
        assert echoed["node"] in ("/first", "/second")
        rates = json.loads(vegrip("topic", "hz", "/diagnostics", "--duration", "3", "--json")[1])
        assert rates["/diagnostics"]["hz"] == pytest.approx(2.0, rel=0.5)

        lost = hub_process("launch")
        os.kill(lost, signal.SIGKILL)
        assert wait_for(lambda: now if (now := hub_process("launch")) != lost else None)
        assert wait_for(
            lambda: "bus_lost" in vegrip("topic", "echo", "/diagnostics", "--count", "2", "--json")[1]
        )
    finally:
        launched.send_signal(signal.SIGINT)
        output, _ = launched.communicate(timeout=PATIENCE)
    lines = [line for line in output.splitlines() if "-- " in line]
    assert launched.returncode == 0
    assert "ended with signal SIGKILL; starts again in 1 s" in output
    assert "the bus was lost" in output
    assert [line.split()[0] for line in lines if line.endswith("stopped")] == ["/second", "/first"]
    assert states() == {}


@pytest.mark.slow
def test_nodes_end_when_their_launcher_is_killed(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(LAUNCH)
    launched = start("launch", str(path))
    try:
        wait_for(both_active)
    finally:
        launched.kill()
        launched.communicate(timeout=PATIENCE)
    wait_for(lambda: True if states() == {} else None)


@pytest.mark.parametrize("times", [1, 10_000], ids=["once", "again and again, as of a dying launcher"])
def test_a_node_that_is_terminated_ends_well_and_leaves_nothing(times):
    process = start("node", "echo", "--set", "transport.channel=single")
    wait_for(the_active_one)
    while process.poll() is None and times:
        process.terminate()
        times -= 1
        time.sleep(0.001)
    output, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert output.splitlines()[-1] == "INFO /echo: ended"
    assert list(runtime_folder("nodes").iterdir()) == []


def test_a_node_whose_launcher_is_dead_already_does_not_start():
    done = subprocess.run(
        [sys.executable, "-m", "vegrip", "node", "echo", "--with-parent", "1"],
        capture_output=True,
        check=False,
    )
    assert done.returncode == -signal.SIGTERM


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("node", "nothing"), 2, "there is no program 'nothing'"),
        (("node", "os:path"), 2, "cannot be"),
        (
            ("node", "echo", "--set", "transport.interface=socketcan", "--set", "transport.channel=nope"),
            4,
            "nope",
        ),
        (("node", "echo", "--set", "parameters.normal_force=-1"), 3, "0 .. 20 N"),
        (("node", "echo", "--set", "nonsense"), 2, "--set"),
        (("node", "echo", "--config", "nothing.toml"), 3, "no launch file"),
        (("node", "thumb", "--config", "demo"), 2, "it has /grasp_force"),
        (("launch", "nothing"), 3, "there is no launch file 'nothing'"),
        (("param", "list", "nobody"), 2, "no node runs"),
        (("lifecycle", "get", "nobody"), 2, "no node runs"),
        (("topic", "echo", "/hand"), 2, "no node runs"),
    ],
)
def test_a_mistake_is_one_sentence_and_the_exit_code(arguments, code, words, vegrip):
    found, shown, complaint = vegrip(*arguments)
    assert (found, shown) == (code, "")
    assert words in complaint
    assert len(complaint.strip().splitlines()) == 1


@pytest.mark.long
def test_who_listens_to_a_node_that_ends_is_told():
    node = start("node", "echo", "--set", "transport.channel=ending")
    try:
        wait_for(lambda: states() or None)
        listener = start("topic", "echo", "/diagnostics")
        assert listener.stdout.readline(), "it listens"
    finally:
        node.terminate()
        node.communicate(timeout=PATIENCE)
    output, _ = listener.communicate(timeout=PATIENCE)
    assert listener.returncode == 4
    assert output.strip().splitlines()[-1] == "vegrip: /echo ended: nothing comes any more"


@pytest.mark.slow
def test_a_node_that_was_suspended_goes_on_and_counts_what_it_missed():
    loop = ("--set", "loop.status_period=0.2", "--set", "loop.deadline=0.3")
    node = start("node", "echo", "--set", "transport.channel=suspended", *loop)
    try:
        pid = wait_for(the_active_one)
        os.kill(pid, signal.SIGSTOP)
        time.sleep(0.5)  # the suspension itself
        os.kill(pid, signal.SIGCONT)
        missed = wait_for(lambda: status if (status := last_status())["deadline_misses"] else None)
        assert missed["state"] == "active"
        assert missed["deadline_misses"] < 20, "one late tick, not one for each of 250 that were skipped"
    finally:
        node.terminate()
        node.communicate(timeout=PATIENCE)


def the_active_one():
    found = list(states().values())
    return found[0][0] if [state for _, state in found] == ["active"] else None


def last_status():
    from vegrip.runtime.registry import ask, find_node

    return ask(find_node("echo"), "status") or {"deadline_misses": 0}


@pytest.mark.long
def test_the_canopen_hand_that_comes_with_vegrip_is_gripped(vegrip):
    launched = start("launch", "canopen")
    try:
        wait_for(both_active)
        lines = vegrip("topic", "echo", "/hand/thumb/force_command", "--count", "20", "--json")[
            1
        ].splitlines()
        commands = [json.loads(line) for line in lines]
        assert len(commands) == 20
        assert all(0.0 <= command["normal_force"] <= 15.0 for command in commands)
        rejected = json.loads(vegrip("topic", "echo", "/diagnostics", "--count", "1", "--json")[1])[
            "rejected"
        ]
        assert not {"not_its_eds", "id_taken"} & set(rejected)
    finally:
        launched.send_signal(signal.SIGINT)
        output, _ = launched.communicate(timeout=PATIENCE)
    assert launched.returncode == 0, output


def test_a_busy_port_is_one_sentence(vegrip):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        given = ("--set", "transport.kind=zmq", "--set", f"transport.publish={address}")
        code, _, complaint = vegrip("node", "echo", *given)
    assert (code, "in use" in complaint) == (4, True)


def test_a_monitor_into_a_pipe_before_any_node_has_said_what_it_waits_for_when_it_is_ended(vegrip):
    process = start("monitor")
    assert process.stdout is not None
    told = [process.stdout.readline() for _ in range(2)]
    process.terminate()
    process.communicate(timeout=PATIENCE)
    assert "--json" in told[0]
    assert "waits for one" in told[1]
    assert vegrip("monitor", "--once")[0] == 2
