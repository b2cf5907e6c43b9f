"""A bench is written from products and few answers, and what was written is read as a hand in parts."""

import io
import json
import sys
from unittest.mock import ANY

import pytest

from vegrip.cli import _bench, main
from vegrip.connect.bench_file import largest_for, which_is_pressed
from vegrip.connect.parts import benches
from vegrip.errors import ConfigError, InputError
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.hands.bench import read_source

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
        ["--sensor", "there.toml", *GRIPPER, "-o", "bench.toml"],
        ["--sensor", "robotiq@/dev/ttyACM0", *GRIPPER, "-o", "bench.toml"],
        [*PADS, "--drive", "there.toml@/dev/ttyUSB0", "-o", "bench.toml"],
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


@pytest.fixture
def connect(tmp_path, monkeypatch, capsys):
    """Return a function that runs the command in a folder, and gives its exit code and what it said."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        code = main(["connect", *words, "-o", "bench.toml", "--no-ask"])
        return code, capsys.readouterr()

    return run


def bench_of(path):
    ((_, bench),) = benches(path)
    return bench


def test_what_is_set_goes_to_the_maps_of_the_pads_or_of_the_drive_that_have_it(connect, tmp_path):
    pads, drive = ["fingers.*.normal_force.unit=mN", "fingers.left.normal_force.sign=-1"], "drive.delay=0.2"
    assert connect(*PADS, *GRIPPER, *(word for one in (*pads, drive) for word in ("--set", one)))[0] == 0
    bench = bench_of(tmp_path / "bench.toml")
    felt = [
        source.plan.hand.fingers[source.names[side]].channels["normal_force"]
        for source in bench.sensors
        for side in source.names
    ]
    assert [(one.unit, one.sign) for one in felt] == [("mN", -1), ("mN", 1)]
    assert bench.drive.plan.hand.drive.delay == 0.2
    assert bench.drive.text == str(tmp_path / "drive.toml")
    assert bench.drive.transport["address"] == "/dev/ttyUSB0"


@pytest.mark.parametrize(
    ("key", "said"),
    [
        (
            "nonsense.key=3",
            "--set nonsense.key: of a bench there are fingers.left, fingers.right, fingers.jaw",
        ),
        ("fingers.thumb.axes=[]", "--set fingers.thumb.axes: of a bench there are"),
        ("fingers.left=3", "--set fingers.left: of a bench there are"),
        ("rate=3", "a map of yours, FILE@PORT"),
        ("fingers.*.normal_force.uint=mN", "unknown key 'uint'"),
        ("drive.dealy=0.1", "unknown key 'dealy'"),
    ],
)
def test_a_key_that_no_part_has_is_refused_in_one_sentence(connect, tmp_path, key, said):
    code, told = connect(*PADS, *GRIPPER, "--set", key)
    assert code in (2, 3)
    assert said in told.err
    assert told.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


ATI = ["--sensor", "ati-net-ft@1.1.1.1:49152", "--sensor", "ati-net-ft@1.1.1.2:49152"]
MOTOR = ["gain='30 /N'", "closed=[2800]", "opened=1024"]


def test_products_with_values_to_be_measured_are_taken_once_these_are_set(connect, tmp_path):
    code, told = connect(*ATI, *GRIPPER)
    assert code == 3
    assert "ati-net-ft@1.1.1.1:49152: scale of normal_force is not known" in told.err
    known = [
        "--set",
        "fingers.left.normal_force.scale=-1e-6",
        "--set",
        "fingers.right.normal_force.scale=-2e-6",
    ]
    code, told = connect(*ATI, "--drive", "dynamixel-x@/dev/ttyUSB0", *known)
    assert code == 3
    assert "dynamixel-x@/dev/ttyUSB0: gain of command is not known" in told.err
    motor = [word for one in MOTOR for word in ("--set", f"fingers.*.command.{one}")]
    assert connect(*ATI, "--drive", "dynamixel-x@/dev/ttyUSB0", *known, *motor) == (0, ANY)
    bench = bench_of(tmp_path / "bench.toml")
    scales = {
        side: source.plan.hand.fingers[side].channels["normal_force"].scale
        for source in bench.sensors
        for side in source.names
    }
    assert scales == {"left": -1e-6, "right": -2e-6}
    assert bench.drive.plan.hand.fingers["jaw"].command.gain == "30 /N"


def test_maps_of_ones_own_are_pads_and_drives_with_or_without_a_port_behind_them(connect, tmp_path):
    measured = ["--set", "fingers.*.taxels.scale=0.002", "--address", "/dev/ttyACM0"]
    assert main(["connect", "--hand", "robotiq-tsf85", "-o", "pad.toml", *measured]) == 0
    (tmp_path / "like.toml").write_text('like = "robotiq-tsf85"\n[fingers."*".taxels]\nscale = 0.003\n')
    assert main(["connect", "--hand", "weiss-wsg50", "-o", "wsg.toml", "--address", "1.1.1.1:1000"]) == 0
    sensors = ["--sensor", "pad.toml", "--sensor", "like.toml@/dev/ttyACM1"]
    assert connect(*sensors, "--drive", "wsg.toml@1.1.1.9:1000")[0] == 0
    bench = bench_of(tmp_path / "bench.toml")
    pads = {side: source for source in bench.sensors for side in source.names.values()}
    assert [pads[side].transport["address"] for side in pads] == ["/dev/ttyACM0", "/dev/ttyACM1"]
    assert [pads[side].plan.hand.fingers[side].taxels.scale for side in pads] == [0.002, 0.003]
    assert bench.drive.transport["address"] == "1.1.1.9:1000"
    assert bench.drive.path == tmp_path / "wsg.toml"


def test_a_map_without_lines_for_what_must_be_set_is_refused_with_them(connect, tmp_path):
    text = 'database = "x"\nfingers.tip.normal_force = { signal = "a.b" }\n[transport]\nkind = "can"\n'
    (tmp_path / "odd.toml").write_text(text)
    code, told = connect("--sensor", "odd.toml@can0", *GRIPPER)
    assert code == 3
    assert "odd.toml@can0: [fingers.tip] has no lines of its own; call it left there" in told.err


def test_what_is_written_is_one_object_of_json_where_that_is_asked_for(connect, tmp_path):
    code, told = connect(*PADS, *GRIPPER, "--json")
    assert code == 0
    said = json.loads(told.out)
    assert said["map"] == "bench.toml"
    assert said["ready"]
    assert said["fingers"]["right"][0] == "normal_force"
    assert any("20 to 235 N" in one for one in said["price"])


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


@pytest.mark.parametrize("product", ["contactile-papillarray", "robotiq-tsf85"])
def test_two_pads_at_one_port_are_both_in_the_bench(tmp_path, monkeypatch, product):
    monkeypatch.setattr(sys, "stdin", Terminal("\n\n\n-y\nheavy\n0.4\n"))
    felt = iter([{"first": 0.1, "second": 0.1}, {"first": 0.1, "second": -5.0}])
    monkeypatch.setattr(_bench, "listen_to_all", lambda *_: next(felt))
    path, scale = tmp_path / "bench.toml", "fingers.*.taxels.scale=0.001"
    words = ["--set", scale] if product == "robotiq-tsf85" else []
    assert main(["connect", "--sensor", f"{product}@/dev/ttyACM0", *GRIPPER, *words, "-o", str(path)]) == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == ["bench.toml", "pads.toml"]
    (node,) = read_launch_file(path)
    assert node.fingers == bench_of(path).serves == ("first", "second")
    first, second = (bench_of(path).sensors[0].plan.hand.fingers[name] for name in node.fingers)
    assert (first.axes, second.axes) == ((), ("-y", "x", "z"))
    assert [(one.taxels or one.channels["normal_force"]).sign for one in (first, second)] == [-1, -1]


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
    drive = read_source("robotiq-2f85@/dev/ttyUSB0", "")
    force = largest_for(2.0, drive)
    assert force >= 3.0 * 2.0 * 9.81 / (2 * 0.3)
    assert (force - 20.0) / 0.843 == pytest.approx(round((force - 20.0) / 0.843), abs=1e-2)
    assert largest_for(0.01, drive) > 20.0
    with pytest.raises(ConfigError, match="235 N at most"):
        largest_for(20.0, drive)
