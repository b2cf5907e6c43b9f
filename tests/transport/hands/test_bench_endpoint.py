"""Two pads and one gripper are one hand: one force goes out, and where one dies what is left goes on."""

import math
import re
import time
from contextlib import ExitStack, closing
from types import SimpleNamespace

import pytest
from benches import Devices, command, write_bench

from vegrip.clock import NS
from vegrip.errors import ConfigError, DeviceError
from vegrip.grip.safety.drive import DriveLimits
from vegrip.messages import FingertipState
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.endpoint import NONE_BROKEN, Endpoint
from vegrip.transport.hands import bench_endpoint
from vegrip.transport.hands.bench import read_source
from vegrip.transport.hands.wrist_load import LoadSettings, WristLoad
from vegrip.transport.maps.conditions import ConditionMap
from vegrip.transport.maps.products import map_of
from vegrip.transport.open import Hand, open_endpoint

PATIENCE = 5.0  # [s]


class Rig:
    """The bench of a folder, opened, and its devices."""

    def __init__(self, folder, stack, **keys):
        (node,) = read_launch_file(write_bench(folder, **keys))
        self.devices = Devices(folder, stack)
        self.endpoint = stack.enter_context(closing(open_endpoint(node.transport, Hand(node.fingers))))
        self.heard = []

    def until(self, is_so, **forces):
        """Exchange states and commands until ``is_so()``."""
        deadline = time.monotonic() + PATIENCE
        while not is_so():
            assert time.monotonic() < deadline, (self.devices.told, self.endpoint.rejected)
            self.devices.feel(**forces)
            self.heard += self.endpoint.receive(0.001)

    def press(self, **forces):
        now = time.monotonic_ns()
        for finger, force in forces.items():
            self.endpoint.send(command(finger, force, now))


@pytest.fixture
def rig(tmp_path):
    with ExitStack() as stack:
        yield Rig(tmp_path, stack)


def test_states_of_all_parts_come_under_the_names_of_the_hand(rig):
    rig.until(lambda: {each.finger for each in rig.heard} >= {"left", "right"}, left=3.0, right=2.9)
    felt = {each.finger: each.normal_force for each in rig.heard if isinstance(each, FingertipState)}
    assert felt["left"] == pytest.approx(3.0)
    assert felt["right"] == pytest.approx(2.9)


def test_the_drive_gets_the_largest_force_that_a_finger_needs_rounded_up_to_its_steps(rig):
    rig.until(lambda: bool(rig.heard), left=3.0, right=3.0)
    rig.press(left=22.0, right=26.0)
    rig.until(lambda: bool(rig.devices.told))
    rig.until(lambda: rig.press(left=22.0, right=26.0) or rig.devices.told[-1] >= 26.0)
    assert rig.devices.told[-1] == pytest.approx(20.0 + 8 * 0.84)  # 26.72
    assert all(force == 0.0 or force >= 20.0 for force in rig.devices.told)  # 0: what it felt at the start


def test_what_the_gripper_cannot_do_is_said_and_not_pretended(rig, monkeypatch):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    rig.press(left=2.0, right=3.3)
    rig.until(lambda: "more_than_needed" in rig.endpoint.rejected, left=20.0, right=20.0)
    said = rig.endpoint.hints["more_than_needed"]
    assert said == "the least that this gripper can is 20 N, 6.1 times what is needed (3.3 N)"


def test_a_sensor_that_dies_is_named_and_the_rest_goes_on(rig, monkeypatch):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    monkeypatch.setattr(bench_endpoint, "SILENT_NS", NS // 10)
    rig.until(lambda: {each.finger for each in rig.heard} >= {"left", "right"}, left=25.0, right=25.0)
    rig.press(left=25.0, right=25.0)
    rig.devices.unplug("left")
    rig.until(lambda: "lost_left" in rig.endpoint.rejected, right=25.0)
    assert "left.toml" in rig.endpoint.hints["lost_left"]
    assert "right and the drive go on" in rig.endpoint.hints["lost_left"]
    assert "lost_right" not in rig.endpoint.rejected
    before = len(rig.heard)
    rig.until(lambda: len(rig.heard) > before, right=25.0)
    assert rig.devices.told[-1] >= 25.0
    assert "back_left" not in rig.endpoint.rejected
    rig.devices.plug("left")
    rig.until(lambda: "back_left" in rig.endpoint.rejected, left=25.0, right=25.0)
    assert rig.endpoint.hints["back_left"].endswith("is received again")


@pytest.mark.parametrize(
    ("gone", "goes_on"),
    [
        (["left"], "right and the drive go on"),
        (["left", "drive"], "right goes on"),
        (["left", "right"], ""),
    ],
)
def test_of_parts_that_have_gone_none_is_said_to_go_on(gone, goes_on):
    now = time.monotonic_ns()
    parts = [bench_endpoint.Part(name, name, Line(), {"tip": name}) for name in ("left", "right")]
    parts.append(bench_endpoint.Part("drive", "gripper.toml", Line(), {"jaws": "jaws"}, "drive"))
    endpoint = bench_endpoint.BenchEndpoint(
        parts, [bench_endpoint.Drive(parts[2], ("jaws",), ("left", "right"), DriveLimits())]
    )
    for part in parts:
        part.received = now
        if part.name in gone:
            part.received, part.endpoint.rejected = now - 2 * NS, {"silent": 1}
    endpoint._look(now)
    assert endpoint.hints["lost_left"].partition("no lower")[2].removeprefix("; ") == goes_on


def test_a_drive_that_dies_is_named_and_the_sensors_are_still_heard(rig, monkeypatch):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    rig.until(lambda: rig.press(left=25.0, right=25.0) or rig.endpoint._drive.known > 0.0, left=25.0)
    rig.devices.unplug("gripper")
    rig.until(
        lambda: rig.press(left=25.0, right=25.0) or "lost_drive" in rig.endpoint.rejected,
        left=25.0,
        right=25.0,
    )
    said = rig.endpoint.hints["lost_drive"]
    assert "does not answer" in said
    assert "25" in said
    before = len(rig.heard)
    rig.until(lambda: len(rig.heard) > before, left=25.0, right=25.0)


def test_a_drive_that_is_lost_presses_as_it_was_commanded_when_it_last_answered_until_it_is_back(
    rig, monkeypatch
):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    drive = rig.endpoint._drive
    rig.until(lambda: rig.press(left=25.0, right=25.0) or drive.known > 0.0, left=25.0, right=25.0)
    rig.devices.unplug("gripper")
    rig.until(lambda: "lost_drive" in rig.endpoint.rejected, left=25.0, right=25.0)
    rig.until(lambda: rig.press(left=55.0, right=55.0) or drive.commanded.force > 55.0)
    late = time.monotonic_ns() + NS
    assert drive.pressing(late) == pytest.approx(20.0 + 6 * 0.84 - 0.5)  # 25.04 N less its hysteresis
    assert "back_drive" not in rig.endpoint.rejected
    rig.devices.plug("gripper")
    rig.until(lambda: "back_drive" in rig.endpoint.rejected, left=25.0, right=25.0, gripper=25.0)
    rig.until(lambda: rig.press(left=55.0, right=55.0) or rig.devices.told[-1] > 55.0)


def test_while_a_new_force_is_on_its_way_a_drive_presses_with_the_lesser_of_both():
    drive, _ = made_up_drive()
    felt = []
    for second, force in enumerate((20.0, 26.0, 0.0), 1):
        drive.take(command("left", force, second * NS))
        felt += [drive.pressing(second * NS + wait) for wait in (NS // 100, NS // 10)]
    assert felt == [0.0, 20.0, 20.0, 26.0, 0.0, 0.0]


def made_up_drive():
    """Return a drive of whole newtons from 20 N on, 50 ms late, and its line."""
    line = SimpleNamespace(send=lambda _: None, rejected={}, heard=0, obeys=True)
    part = bench_endpoint.Part("drive", "", line, {}, "drive")
    limits = DriveLimits(minimum=20.0, maximum=235.0, resolution=1.0, delay=0.05)
    return bench_endpoint.Drive(part, ("jaws",), ("left", "right"), limits), line


def test_a_drive_that_answers_and_is_not_ready_presses_as_it_did_and_is_lowered_by_nothing_but_release():
    drive, line = made_up_drive()

    def after(second, force):
        """Need a force for ten seconds; return what is commanded and what is pressed."""
        for late in range(second * 10, second * 10 + 100):
            line.heard = late * NS // 10
            drive.take(command("left", force, late * NS // 10))
        return drive.commanded.force, drive.pressing(line.heard)

    assert after(1, 30.0) == (30.0, 30.0)
    line.obeys = False
    assert after(20, 50.0) == (50.0, 30.0)
    assert after(40, 22.0) == (31.0, 30.0)  # no lower than a step above what it took last
    assert after(60, 0.0) == (0.0, 30.0)
    assert after(80, 40.0) == (40.0, 30.0)
    line.obeys = True
    assert drive.pressing(line.heard) == 40.0  # its answer came long after the command
    assert after(100, 40.0) == (40.0, 40.0)


def test_a_drive_that_answers_no_more_took_no_command_since_its_last_answer():
    drive, line = made_up_drive()
    for milliseconds in range(1000, 2000, 10):
        line.heard = min(milliseconds, 1500) * NS // 1000
        drive.take(command("left", 30.0 if milliseconds < 1480 else 60.0, milliseconds * NS // 1000))
    assert drive.commanded.force == 60.0
    assert drive.pressing(2 * NS) == 30.0  # 20 ms after the new force it spoke for the last time


class Line(Endpoint):
    """A part in the time of the test."""

    rejected = NONE_BROKEN  # nothing goes wrong
    conditions = frozenset()

    def __init__(self):
        self.coming, self.told = [], []

    def receive(self, timeout):  # noqa: ARG002
        found, self.coming = self.coming, []
        self.arrivals = [0] * len(found)
        return found

    def send(self, message):
        self.told.append(message.normal_force)

    def close(self):
        pass


class WristBench:
    """A gripper on a sensor at the wrist, which feels ``mass`` [kg] beside the gripper."""

    def __init__(self):
        self.wrist, self.drive, self.now = Line(), Line(), time.monotonic_ns()
        parts = [
            bench_endpoint.Part("wrist", "wrist.toml", self.wrist, {"tip": "tip"}, "wrist"),
            bench_endpoint.Part("drive", "gripper.toml", self.drive, {"jaws": "jaws"}, "drive"),
        ]
        drive = bench_endpoint.Drive(parts[1], ("jaws",), ("left", "right"), DriveLimits(minimum=20.0))
        load = WristLoad(LoadSettings(source="wrist.toml", mass=0.9))
        self.endpoint = bench_endpoint.BenchEndpoint(parts, [drive], load)

    def felt(self, mass, seconds):
        """Return the last tangential force [N] of the left finger, None where no state came."""
        found = []
        for _ in range(round(seconds * 100)):
            self.now += NS // 100
            self.wrist.coming = [
                FingertipState(self.now, "tip", 1, 0.0, 0.0, -9.81 * (0.9 + mass), torque_z=0.0)
            ]
            found += [one for one in self.endpoint.receive(0.0) if one.finger == "left"]
        return found[-1].tangential_force_x if found else None


def test_while_the_gripper_is_weighed_nothing_is_felt_of_its_fingers(monkeypatch):
    monkeypatch.setattr(bench_endpoint, "ROUND_NS", 0)
    bench = WristBench()
    assert bench.felt(0.0, 0.9) is None
    assert bench.felt(0.0, 0.2) == pytest.approx(0.0, abs=1e-9)
    assert bench.felt(1.0, 20.0) == pytest.approx(0.5 * 9.81, rel=1e-2)


def test_pads_that_feel_no_load_are_heard_once_the_gripper_is_weighed_so_that_it_is_not_closed_before(
    monkeypatch,
):
    monkeypatch.setattr(bench_endpoint, "ROUND_NS", 0)
    bench, pad = WristBench(), Line()
    part = bench_endpoint.Part("left", "left.toml", pad, {"tip": "left"})
    parts, drive = (*bench.endpoint._parts, part), bench.endpoint._drive
    bench.endpoint = bench_endpoint.BenchEndpoint(parts, [drive], bench.endpoint._wrist)

    def pressed(load, force=3.0):
        pad.coming = [FingertipState(bench.now, "tip", 1, force, load, load)]
        found = [each for each in bench.endpoint.receive(0.0) if each.finger == "left"]
        return found[-1].tangential_force_x if found else None

    assert bench.felt(0.0, 0.5) is None
    assert pressed(math.nan) is None
    assert pressed(0.5) == 0.5  # one that feels its load waits for nothing
    bench.felt(0.0, 1.0)
    assert pressed(math.nan) == pytest.approx(0.0, abs=1e-9)
    bench.endpoint._tell("lost_wrist", bench.endpoint._of_loss(parts[0]))
    assert "left, right held" in bench.endpoint.hints["lost_wrist"]


def test_a_gripper_that_holds_when_the_node_starts_is_not_weighed_with_its_object_but_asked_for(monkeypatch):
    monkeypatch.setattr(bench_endpoint, "ROUND_NS", 0)
    bench = WristBench()
    bench.drive.conditions = {"holding"}
    assert bench.felt(1.0, 3.0) is None
    assert "gripper.toml holds something" in bench.endpoint.hints["not_empty"]
    assert bench.endpoint.rejected["not_empty"] == 300
    bench.endpoint.zero()  # its owner bears the object
    bench.felt(0.0, 1.5)
    assert bench.felt(1.0, 20.0) == pytest.approx(0.5 * 9.81, rel=1e-2)
    bench = WristBench()
    bench.drive.conditions = {"holding"}
    bench.felt(1.0, 1.0)
    bench.drive.conditions = frozenset()  # it was taken out
    bench.felt(0.0, 1.5)
    assert bench.felt(1.0, 20.0) == pytest.approx(0.5 * 9.81, rel=1e-2)


def test_jaws_that_feel_different_forces_are_named_with_both(rig, monkeypatch):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    rig.until(lambda: "uneven_jaws" in rig.endpoint.hints, left=25.0, right=15.0)
    assert "one touches something else" in rig.endpoint.hints["uneven_jaws"]


def test_a_part_is_not_said_to_be_lost_because_the_node_did_not_listen(rig):
    rig.until(lambda: {each.finger for each in rig.heard} >= {"left", "right"}, left=25.0, right=25.0)
    long_ago = time.monotonic_ns() - 10 * NS
    rig.endpoint._looked = rig.endpoint._opened = long_ago
    for part in rig.endpoint._parts:
        part.received, part.lost = long_ago if part.received else 0, -1
    rig.endpoint._look(time.monotonic_ns())
    assert not [name for name in rig.endpoint.rejected if name.startswith("lost_")]


def test_a_unit_that_cannot_be_is_named_by_what_the_drive_can(rig, monkeypatch):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    rig.until(lambda: "impossible_force" in rig.endpoint.hints, left=25.0e3, right=25.0)
    said = rig.endpoint.hints["impossible_force"]
    assert said.startswith("left ")
    assert "the gripper is commanded 60 N at most: 'unit' or 'scale'" in said


def test_a_drive_that_dies_before_it_was_told_anything_is_not_said_to_hold_nothing(rig, monkeypatch):
    monkeypatch.setattr(bench_endpoint, "LOOK_NS", 0)
    rig.until(lambda: bool(rig.heard), left=25.0, right=25.0)
    rig.devices.unplug("gripper")
    rig.until(lambda: "lost_drive" in rig.endpoint.hints, left=25.0, right=25.0)
    assert "it holds what it was commanded before" in rig.endpoint.hints["lost_drive"]


def test_jaws_that_feel_the_same_but_for_their_gains_are_not(rig):
    end = time.monotonic() + 1.5
    rig.until(lambda: time.monotonic() > end, left=25.0, right=23.5)
    assert "uneven_jaws" not in rig.endpoint.rejected


def test_a_hand_of_one_map_is_the_same_endpoint_with_one_part(tmp_path):
    write_bench(tmp_path, minimum=5.0)
    with ExitStack() as stack:
        devices = Devices(tmp_path, stack, ("gripper",))
        table = {
            "kind": "serial",
            "map": str(tmp_path / "gripper.toml"),
            "address": str(tmp_path / "tty_gripper"),
        }
        endpoint = stack.enter_context(closing(open_endpoint(table, Hand(("gripper",)))))
        assert isinstance(endpoint, bench_endpoint.BenchEndpoint)
        endpoint.send(command("gripper", 6.0, time.monotonic_ns()))
        deadline = time.monotonic() + PATIENCE
        while not devices.told and time.monotonic() < deadline:
            devices.feel(gripper=5.0)
            endpoint.receive(0.001)
    assert devices.told[-1] == pytest.approx(5.0 + 2 * 0.84)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        (
            'drive = "gripper.toml"',
            'serves = ["left", "right"]',
            "'serves' names left, right, and no 'drive' presses",
        ),
        (
            'drive = "gripper.toml"',
            'drive = "robotiq-2f85"',
            "does not say at which port it is, as robotiq-2f85@",
        ),
        ('drive = "gripper.toml"', 'drive = "robotiq-2f85@"', "does not say at which port it is"),
        (
            'drive = "gripper.toml"',
            'drive = "robotiq-2f85@{left}"',
            "are both at {left}; each has its own port",
        ),
        ("drive =", 'serves = ["left", "left"]\ndrive =', "'serves' names a finger twice"),
    ],
)
def test_parts_that_do_not_belong_together_are_refused_in_a_sentence(tmp_path, before, after, said):
    path = write_bench(tmp_path)
    port = str(tmp_path / "tty_left")
    path.write_text(path.read_text().replace(before, after.format(left=port)))
    with pytest.raises(ConfigError, match=re.escape(said.format(left=port))) as refused:
        read_launch_file(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("axes", ["", 'axes = ["y", "z", "x"]', 'axes = ["-z", "y", "x"]'])
def test_a_sensor_at_the_wrist_tells_the_torque_of_its_closing_direction_in_whatever_axes(tmp_path, axes):
    text = map_of("bota-sensone").read_text().replace("[fingers.tip]", f"[fingers.tip]\n{axes}")
    (tmp_path / "wrist.toml").write_text(text.replace('address = ""', 'address = "/dev/ttyUSB1"'))
    wrist = read_source(str(tmp_path / "wrist.toml"), "")
    assert wrist.plan.fingers[0].measured >= {"normal_force", "torque_z"}


@pytest.mark.parametrize("missing", ["left", "gripper"])
def test_a_port_that_is_not_there_is_named_and_the_others_are_given_back(tmp_path, missing):
    (node,) = read_launch_file(write_bench(tmp_path))
    with ExitStack() as stack:
        Devices(tmp_path, stack, {"left", "right", "gripper"} - {missing})
        for _ in range(2):  # a port that was not given back would be busy the second time
            with pytest.raises(DeviceError, match=f"tty_{missing} cannot be opened: there is no such file"):
                open_endpoint(node.transport, Hand(node.fingers))


def test_a_port_that_another_program_has_is_named(tmp_path):
    (node,) = read_launch_file(write_bench(tmp_path))
    with ExitStack() as stack:
        Devices(tmp_path, stack)
        stack.enter_context(closing(open_endpoint(node.transport, Hand(node.fingers))))
        with pytest.raises(DeviceError, match="another program has it"):
            open_endpoint(node.transport, Hand(node.fingers))


def test_a_fault_that_a_part_says_is_named_with_its_port(rig):
    part = rig.endpoint._parts[-1]
    rig.until(lambda: bool(rig.heard), left=3.0, right=3.0)
    assert rig.endpoint.device_faults == set()
    part.endpoint._conditions._maps["too_hot"] = ConditionMap(where={"felt.force": 0})
    part.endpoint._conditions.now.add("too_hot")
    assert rig.endpoint.device_faults == {(part.where, "too_hot")}
    assert "gripper.toml" in part.where


def test_a_file_that_feels_and_presses_is_opened_once(tmp_path):
    path = write_bench(tmp_path)
    path.write_text('sensors = ["gripper.toml"]\ndrive = "gripper.toml"\n')
    (node,) = read_launch_file(path)
    assert node.fingers == ("gripper",)
    with ExitStack() as stack:
        Devices(tmp_path, stack, ("gripper",))
        endpoint = stack.enter_context(closing(open_endpoint(node.transport, Hand(node.fingers))))
        assert len(endpoint._parts) == 1
