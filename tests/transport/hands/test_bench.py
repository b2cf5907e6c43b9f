"""A launch file names what feels and what squeezes; what does not fit together is refused in a sentence."""

import pytest
from benches import GRIPPER, PAD, write_bench

from vegrip.config import build
from vegrip.errors import VegripError
from vegrip.grip.parameters import GraspParameters
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.hands.bench import BenchSettings, read_bench
from vegrip.transport.open import Hand, open_endpoint

NODE = '[[node]]\nprogram = "grasp_force"\n'


def read(folder, text):
    (folder / "bench.toml").write_text(text)
    return read_launch_file(folder / "bench.toml")


def test_a_launch_file_names_what_feels_and_what_squeezes(tmp_path):
    (node,) = read_launch_file(write_bench(tmp_path))
    assert node.program == "grasp_force"
    assert node.fingers == ("left", "right")
    assert node.transport["kind"] == "bench"
    assert node.parameters["thumb"] == "left"
    assert node.parameters["grip"]["drive_lag"] == pytest.approx(0.03 + 1 / 50)
    assert node.parameters["limits"]["max_force"] == 60.0  # what the sensors are believed, below 235 N


def test_what_is_stated_goes_before_what_the_maps_say(tmp_path):
    extra = NODE + "parameters.limits.max_force = 30.0\nparameters.grip.drive_lag = 0.1\n"
    (node,) = read_launch_file(write_bench(tmp_path, extra=extra))
    assert node.parameters["limits"]["max_force"] == 30.0
    assert node.parameters["grip"]["drive_lag"] == 0.1
    assert node.transport["largest"] == 30.0


def test_pads_bear_the_largest_force_and_may_feel_half_as_much_again_where_nothing_is_stated(tmp_path):
    limit = "parameters.limits.max_force = "
    for stated, modulus, felt in ((10.0, 3e5, 60.0), (60.0, 1.2e6, 90.0), (150.0, 3e6, 225.0)):
        (node,) = read_launch_file(write_bench(tmp_path, minimum=5.0, extra=f"{NODE}{limit}{stated}\n"))
        assert node.parameters["tip"]["modulus"] == pytest.approx(modulus)
        assert node.parameters["watchdog"]["ranges"]["normal_force"] == [-5.0, felt]
    stated = "parameters.tip.modulus = 7e5\nparameters.watchdog.ranges.normal_force = [-1.0, 200.0]\n"
    (node,) = read_launch_file(write_bench(tmp_path, extra=f"{NODE}{stated}"))
    assert node.parameters["tip"]["modulus"] == 7e5
    assert node.parameters["watchdog"]["ranges"]["normal_force"] == [-1.0, 200.0]
    assert GraspParameters().tip.modulus == 3e5


def test_products_by_name_and_port_are_parts_and_take_the_finger_before_them(tmp_path):
    sensors = '["left=contactile-papillarray@/dev/ttyACM0", "right=contactile-papillarray@/dev/ttyACM1"]'
    write_bench(tmp_path)
    (node,) = read(tmp_path, f'sensors = {sensors}\ndrive = "gripper.toml"\n')
    assert node.fingers == ("left", "right")
    (node,) = read(tmp_path, 'sensors = ["contactile-papillarray@/dev/ttyACM0"]\ndrive = "gripper.toml"\n')
    assert node.fingers == ("first", "second")


def test_a_file_is_at_the_port_behind_it_and_takes_the_finger_before_it(tmp_path):
    folder = tmp_path / "a@b=c"
    folder.mkdir()
    write_bench(folder)
    sensors = '["one=left.toml@/dev/ttyA", "right.toml"]'
    (node,) = read(folder, f'sensors = {sensors}\ndrive = "gripper.toml@/dev/ttyB"\n')
    bench = read_bench(build(BenchSettings, node.transport, ""), "")
    assert node.fingers == ("one", "right")
    at = {name: source.transport["address"] for name, source in bench.parts.items()}
    assert at == {"one": "/dev/ttyA", "right": str(folder / "tty_right"), "drive": "/dev/ttyB"}


TWO = 'sensors = ["left.toml", "right.toml"]\n'
WITH_COMMAND = PAD + '[packets.c]\nstart = "CC"\nlength = 5\n[packets.c.fields]\nf = "f32 le @1 * 1 N"\n'
WITH_COMMAND += '[fingers.{finger}.command]\nsignal = "c.f"\n'


def opened(folder, text):
    (node,) = read(folder, text)
    return open_endpoint(node.transport, Hand(node.fingers))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TWO + 'drive = "left.toml"', "left.toml maps no command, so it is no drive"),
        (TWO + 'drive = "nothing.toml"', "there is no map 'nothing.toml'"),
        (TWO + 'drive = "robotiq@/dev/ttyUSB0"', "there is no map of 'robotiq'"),
        (TWO + 'drive = "weiss-wsg50@192.168.1.20"', "'192.168.1.20'; it must be HOST:PORT"),
        (TWO + 'drive = "weiss-wsg50@/dev/ttyUSB0"', "'/dev/ttyUSB0'; it must be HOST:PORT"),
        (TWO + 'drive = "gripper.toml"\nserves = ["left", "rihgt"]', "'rihgt', which no sensor feels"),
        ('sensors = ["left.toml", "left.toml"]\ndrive = "gripper.toml"', "left is a finger of"),
        (TWO + 'drive = "gripper.toml"\n[transport]\nkind = "can"', "[transport] is of a hand of one map"),
        ('drive = "gripper.toml"', "nothing feels"),
        (TWO + 'serves = ["left"]', "and no 'drive' presses"),
        (TWO + 'drvie = "gripper.toml"\nserves = ["left"]', "did you mean drive?"),
        (TWO + 'drive = "gripper.toml"\n[load]\nfrom = "left.toml"', "'mass'"),
        (
            TWO
            + 'drive = "gripper.toml"\n[[node]]\nprogram = "grasp_force"\nparameters.limits.max_force = 15.0',
            "the least that",
        ),
        (
            TWO + 'drive = "gripper.toml"\n[[node]]\nprogram = "grasp_force"\n'
            "parameters.limits.max_force = '4 kN'",
            "limits.max_force is '4 kN'; give a number in N",
        ),
        (TWO + 'drive = "gripper.toml"\n[load]\nmass = 0.9', "[load] needs from"),
        (TWO + 'drive = "gripper.toml"\n[load]\nmas = 0.9', "'mas'; known are from, mass, share"),
        (TWO + 'drive = "gripper.toml"\n[load]\nsource = "w.toml"', "'source'; known are from, mass, share"),
        (
            'sensors = ["both.toml", "right.toml"]\ndrive = "gripper.toml"',
            "left is commanded by",
        ),
        (
            'sensors = ["left.toml", "same.toml"]\ndrive = "gripper.toml"',
            "each has its own port",
        ),
        (
            'sensors = ["left=contactile-papillarray@/dev/ttyA", "right=contactile-papillarray@/dev/ttyA"]\n'
            'drive = "gripper.toml"',
            "are both at /dev/ttyA; each has its own port, and a hub of two pads is named once",
        ),
        (TWO + 'drive = "stiff.toml"', "'unit'"),
        (
            'sensors = ["drive=paxini-px6ax@/dev/ttyA", "right.toml"]\ndrive = "gripper.toml"',
            "'drive' is what another part",
        ),
        ('sensors = ["wrist.toml"]\ndrive = "gripper.toml"', "'wrist' is what another part"),
    ],
)
def test_what_does_not_fit_together_is_refused_in_one_sentence(tmp_path, text, said):
    write_bench(tmp_path)
    (tmp_path / "both.toml").write_text(WITH_COMMAND.format(finger="left", port="/dev/ttyX"))
    (tmp_path / "same.toml").write_text(PAD.format(finger="right", port=tmp_path / "tty_left"))
    (tmp_path / "wrist.toml").write_text(PAD.format(finger="wrist", port="/dev/ttyX"))
    stiff = GRIPPER.format(port="/dev/ttyX", minimum=20.0) + 'unit = "K"\n'
    (tmp_path / "stiff.toml").write_text(stiff)
    with pytest.raises(VegripError) as refused:
        opened(tmp_path, text)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


LOAD = 'drive = "gripper.toml"\n[load]\nmass = 0.9\n'


@pytest.mark.parametrize(
    ("wrist", "keys", "said"),
    [
        ("pressure.toml", "", "feels no tangential_force_x and no tangential_force_y, without which no load"),
        ("robotiq-2f85@/dev/ttyW", "", "feels no normal_force and no tangential_force_x and no"),
        (
            "unscaled.toml",
            "",
            "feels no tangential_force_x, without which no load is known; write what is '?'",
        ),
        ("paxini-px6ax@/dev/ttyW", "reach = [0.0, 0.1]", "feels no torque_z"),
    ],
)
def test_a_sensor_at_the_wrist_that_does_not_feel_the_load_is_refused(tmp_path, wrist, keys, said):
    write_bench(tmp_path)
    text = PAD.format(finger="tip", port="/dev/ttyW")
    (tmp_path / "pressure.toml").write_text(text[: text.index("[fingers.tip.tangential_force_x]")])
    (tmp_path / "unscaled.toml").write_text(text.replace('p.fx"', 'p.fx"\nscale = "?"'))
    with pytest.raises(VegripError) as refused:
        read(tmp_path, f'{LOAD}from = "{wrist}"\n{keys}')
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_two_pads_at_one_port_are_refused_by_whichever_of_its_names_each_is_given(tmp_path):
    write_bench(tmp_path)
    (tmp_path / "by-id").symlink_to(tmp_path / "tty_left")
    (tmp_path / "right.toml").write_text(PAD.format(finger="right", port=tmp_path / "by-id"))
    with pytest.raises(VegripError, match=r"are both at .*by-id; each has its own port"):
        read(tmp_path, TWO + 'drive = "gripper.toml"')


def test_of_a_load_that_the_wrist_feels_it_is_not_said_that_no_pad_does(tmp_path):
    for finger in ("left", "right"):
        text = PAD.format(finger=finger, port=tmp_path / f"tty_{finger}")
        (tmp_path / f"{finger}.toml").write_text(text[: text.index(f"[fingers.{finger}.tangential_force_x]")])
    (tmp_path / "gripper.toml").write_text(GRIPPER.format(port=tmp_path / "tty_gripper", minimum=20.0))
    text = 'sensors = ["left.toml", "right.toml"]\ndrive = "gripper.toml"\n'
    load = 'load = { from = "bota-sensone@/dev/ttyW", mass = 0.9 }\n'

    def said(extra):
        (node,) = read(tmp_path, text + extra)
        bench = read_bench(build(BenchSettings, node.transport, ""), "")
        return [one for one in bench.sentences() if "no slip margin" in one]

    assert len(said("")) == 2
    assert said(load) == []
