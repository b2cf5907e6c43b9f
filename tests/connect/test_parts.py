"""Each part of a hand is tried alone: who answers is named, and who does not with what to do."""

import os
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "transport" / "hands"))

from benches import Devices, write_bench
from drives import Running

from vegrip.connect.parts import try_parts
from vegrip.runtime.doctor import Grade
from vegrip.transport.hands.device_endpoint import PtyPort


@pytest.fixture
def bench(tmp_path):
    """Give a bench whose devices are served in a thread: the forces they feel, and the path of its file."""
    forces, over = {"left": 0.05, "right": -0.02, "gripper": 0.0}, threading.Event()
    path = write_bench(tmp_path)
    with ExitStack() as stack:
        devices = Devices(tmp_path, stack)

        def serve():
            while not over.wait(0.002):
                devices.feel(**forces)

        thread = threading.Thread(target=serve)
        thread.start()
        yield path, forces, devices
        over.set()
        thread.join()


def grades(found):
    return {finding.check: finding.grade for finding in found}


def test_each_part_that_answers_is_named_with_what_it_says(bench):
    path, _, _ = bench
    found = try_parts(path, 2.0)
    assert grades(found) == {"left": Grade.OK, "right": Grade.OK, "drive": Grade.OK}
    assert "states/s, left 0.05 N" in found[0].text
    assert "20 to 235 N in steps of 0.84 N" in found[2].text


@pytest.mark.parametrize(
    ("force", "grade", "said"),
    [(812.0, Grade.FAIL, "no fingertip feels that at rest"), (7.0, Grade.WARN, "left 7.00 N")],
)
def test_a_unit_that_cannot_be_and_a_zero_that_has_drifted_are_said(bench, force, grade, said):
    path, forces, _ = bench
    forces["left"] = force
    finding = try_parts(path, 2.0)[0]
    assert finding.grade is grade
    assert said in finding.text


def test_a_port_that_is_not_there_a_silent_one_and_another_device_are_told_apart(tmp_path):
    path = write_bench(tmp_path)
    silent, other = PtyPort(str(tmp_path / "tty_left")), PtyPort(str(tmp_path / "tty_right"))
    over = threading.Event()

    def babble():
        while not over.wait(0.005):
            os.write(other._end, b"$GPGGA,123519,4807.038,N*47\r\n")

    thread = threading.Thread(target=babble)
    thread.start()
    try:
        left, right, drive = try_parts(path, 0.3)
    finally:
        over.set()
        thread.join()
        silent.close()
        other.close()
    assert {one.grade for one in (left, right, drive)} == {Grade.FAIL}
    assert "nothing comes within" in left.text
    assert "another device" in right.text
    assert "there is no such file" in drive.text
    assert drive.remedy == f"its port stands at [transport] in {tmp_path / 'gripper.toml'}"


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("'sensors'", 'sensors = ["left=contactile-papillarray@{port}"]\ndrive = "gripper.toml"'),
        ("'drive'", 'sensors = ["left.toml"]\ndrive = "robotiq-2f85@{port}"'),
        ("'from' of [load]", 'drive = "gripper.toml"\nload = {{ from = "bota-sensone@{port}", mass = 0.9 }}'),
    ],
)
def test_a_port_that_is_busy_is_named_with_its_place_and_the_program_that_has_it(tmp_path, key, text):
    path, port = write_bench(tmp_path), PtyPort(str(tmp_path / "tty"))
    path.write_text(text.format(port=port.address))
    holder = (
        "import fcntl, sys; f = open(sys.argv[1]); fcntl.flock(f, fcntl.LOCK_EX); print(flush=True); input()"
    )
    command = [sys.executable, "-c", holder, port.address]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        program.stdout.readline()
        (busy,) = [one for one in try_parts(path, 0.1) if "another program has it" in one.text]
        program.communicate("\n")
    port.close()
    assert busy.grade is Grade.FAIL
    assert port.address in busy.text
    assert f"(process {program.pid})" in busy.text
    assert busy.remedy == f"its port stands at {key} in {path}"


@pytest.mark.parametrize(
    ("fault", "lost", "grade", "said"),
    [
        (0, 0, Grade.OK, "in steps of 0.843 N"),
        (14, 0, Grade.WARN, "it says of itself: overcurrent"),
        (0, 2, Grade.WARN, "2 requests had no answer"),
    ],
)
def test_a_drive_that_answers_is_no_other_device_and_what_it_says_of_itself_is_said(
    tmp_path, fault, lost, grade, said
):
    drive = Running("robotiq-2f85", tmp_path)
    drive.device.commanded["ACT"], drive.device.fault = 1, fault
    answered, polls = drive.device.answered, []

    def cut(data, now):
        size, answer = answered(data, now)
        polls.append(answer)
        return size, answer[:4] if 5 <= len(polls) < 5 + lost else answer

    drive.device.answered = cut
    path = tmp_path / "bench.toml"
    path.write_text(
        f'sensors = ["contactile-papillarray@/none"]\ndrive = "robotiq-2f85@{drive.port.address}"'
    )
    finding = try_parts(path, 1.0)[-1]
    drive.close()
    assert finding.grade is grade
    assert said in finding.text
