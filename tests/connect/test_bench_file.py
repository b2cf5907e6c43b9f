"""A bench is written from products and few answers, and what was written is read as a hand in parts."""

import io
import sys

import pytest

from vegrip.cli import _bench, main
from vegrip.connect.bench_file import largest_for, sources_of, which_is_pressed
from vegrip.errors import ConfigError, InputError
from vegrip.runtime.launch_file import read_launch_file

PADS = ["--sensor", "contactile-papillarray@/dev/ttyACM0", "--sensor", "contactile-papillarray@/dev/ttyACM1"]
GRIPPER = ["--drive", "robotiq-2f85@/dev/ttyUSB0"]


def test_a_bench_is_written_and_read_as_a_hand_of_two_fingers_and_one_drive(tmp_path):
    path = tmp_path / "bench.toml"
    written = [
        "-o",
        str(path),
        "--no-ask",
        "--heaviest",
        "1.0",
        "--set",
        'fingers.right.axes=["-y", "x", "z"]',
    ]
    assert main(["connect", *PADS, *GRIPPER, *written]) == 0
    (node,) = read_launch_file(path)
    assert node.fingers == ("left", "right")
    assert node.parameters["limits"]["max_force"] == pytest.approx(3.0 * 9.81 / 0.6, abs=0.85)
    assert 'address = "/dev/ttyACM1"' in (tmp_path / "right.toml").read_text()
    assert 'axes = ["-y", "x", "z"]' in (tmp_path / "right.toml").read_text()
    assert "axes" not in (tmp_path / "left.toml").read_text().replace("set axes", "")


@pytest.mark.parametrize(
    "arguments",
    [
        [*PADS, "-o", "bench.toml"],
        [*PADS, *GRIPPER],
        [*PADS, *GRIPPER, "-o", "bench.toml", "--fingers", "left"],
        ["--sensor", "contactile-papillarray", *GRIPPER, "-o", "bench.toml"],
        [*PADS, "--drive", "bota-sensone@/dev/ttyUSB0", "-o", "bench.toml"],
        [*PADS, *GRIPPER, "-o", "bench.toml", "--heaviest", "100"],
        [*PADS, *GRIPPER, "-o", "bench.toml", "--heaviest", "nan"],
        [*PADS, *GRIPPER, "-o", "left.toml"],  # the map of the left pad, too
        [*PADS, *GRIPPER, "-o", "bench.toml", "--fingers", "left,left"],
        [*PADS, *GRIPPER, "-o", "bench.toml", "--fingers", "a/b,c"],
        [*PADS, *GRIPPER, "-o", "bench.toml", "--fingers", "left,drive"],
        [*PADS[:2], *PADS[:2], *GRIPPER, "-o", "bench.toml"],
    ],
)
def test_what_is_no_bench_is_refused(tmp_path, monkeypatch, arguments, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["connect", *arguments, "--no-ask"]) in (2, 3)
    assert "Traceback" not in capsys.readouterr().err
    assert not list(tmp_path.glob("left.toml"))


@pytest.mark.parametrize("drive", ["contactile-papillarray@/dev/ttyX", "robotiq-2f85@/dev/ttyACM0"])
def test_the_files_of_a_bench_stay_when_a_new_one_does_not_fit_together(tmp_path, drive):
    kept = [tmp_path / name for name in ("bench.toml", "left.toml")]
    for path in kept:
        path.write_text(f"mine: {path.name}")
    words = ["--drive", drive, "-o", str(tmp_path / "bench.toml"), "--no-ask", "--force"]
    assert main(["connect", *PADS, *words]) == 3
    assert [path.read_text() for path in kept] == ["mine: bench.toml", "mine: left.toml"]
    assert sorted(tmp_path.iterdir()) == kept


class Terminal(io.StringIO):
    """What a person types."""

    def isatty(self):
        return True


def test_odd_answers_are_asked_for_again_and_a_sign_holds_for_all_pads_of_a_product(tmp_path, monkeypatch):
    typed = ["", "", "", "up", "-y", "", "heavy", "nan", "-1", "0", "0.4"]
    monkeypatch.setattr(sys, "stdin", Terminal("\n".join(typed) + "\n"))
    rest = dict.fromkeys(PADS[1::2], 0.1)
    felt = iter([rest, rest, {PADS[1]: -0.1, PADS[3]: -5.0}])  # the first press was not felt
    monkeypatch.setattr(_bench, "listen_to_all", lambda *_: next(felt))
    path = tmp_path / "bench.toml"
    assert main(["connect", *PADS, *GRIPPER, "-o", str(path)]) == 0
    (node,) = read_launch_file(path)
    assert node.parameters["limits"]["max_force"] < 26.0
    left, right = ((tmp_path / f"{side}.toml").read_text() for side in ("left", "right"))
    assert 'address = "/dev/ttyACM1"' in left  # it was the second that was pressed
    assert 'axes = ["-y", "x", "z"]' in left
    assert "sign = -1" in left
    assert "sign = -1" in right


def test_the_pad_that_is_pressed_tells_which_it_is_and_its_sign():
    rest = {"a": 0.1, "b": -0.2}
    assert which_is_pressed(rest, {"a": 0.2, "b": 4.0}) == ("b", 1)
    assert which_is_pressed(rest, {"a": -3.0, "b": -0.1}) == ("a", -1)


@pytest.mark.parametrize(
    ("pressed", "said"),
    [
        ({"a": 0.3, "b": 0.1}, "not clear"),
        ({"a": 3.0, "b": 2.5}, "not clear"),
        ({"a": 3.0, "b": float("nan")}, "nothing comes of b"),
    ],
)
def test_a_press_that_is_not_clear_is_asked_for_again(pressed, said):
    with pytest.raises(InputError, match=said):
        which_is_pressed({"a": 0.0, "b": 0.0}, pressed)


def test_the_largest_force_holds_the_weight_three_times_and_is_one_that_the_drive_makes():
    (drive,) = sources_of(["robotiq-2f85@/dev/ttyUSB0"])
    force = largest_for(2.0, drive)
    assert force >= 3.0 * 2.0 * 9.81 / (2 * 0.3)
    assert (force - 20.0) / 0.843 == pytest.approx(round((force - 20.0) / 0.843), abs=1e-2)
    assert largest_for(0.01, drive) > 20.0
    with pytest.raises(ConfigError, match="235 N at most"):
        largest_for(20.0, drive)
