"""Each part of a hand is tried alone: who answers is named, and who does not with what to do."""

import os
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "transport" / "hands"))

from benches import Devices, write_bench

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
