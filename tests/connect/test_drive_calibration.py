"""A drive on a stiff object: gain, steps, delay, hysteresis are recovered; however it ends, the jaws open."""

import json
import math
import tomllib
from dataclasses import replace

import pytest

from tests.connect.grippers import Gripper, Line, Pad
from tests.transport.hands.benches import write_bench
from vegrip.cli import main
from vegrip.clock import NS, SimulatedClock
from vegrip.connect import drive_sweep
from vegrip.connect.drive_response import respond
from vegrip.connect.drive_sweep import Rig, plan_sweep
from vegrip.connect.measured_drive import measured_map, measured_settings
from vegrip.errors import DeviceError, InputError, UsageError
from vegrip.grip.safety.drive import DriveLimits
from vegrip.transport.hands.bench import Source, read_source
from vegrip.transport.mapped.commands import law_of

STATED = DriveLimits(resolution=0.84, rate=50.0, delay=0.03, minimum=20.0, maximum=235.0, hysteresis=0.5)
MOST = 70.0


@pytest.fixture(autouse=True)
def _few_looks(monkeypatch):
    monkeypatch.setattr(drive_sweep, "NAP_S", 4e-3)  # [s] as often as a pad is heard


class Bench:
    """A gripper with two pads, without files."""

    def __init__(self, clock=None, dies=math.inf, **gripper):
        self.clock = clock or SimulatedClock(NS)
        self.gripper = Gripper(**gripper)
        self.drive = Line(self.gripper, self.clock)
        self.pads = {name: Pad(name, self.gripper, self.clock) for name in ("left", "right")}
        self.pads["left"].dies = dies

    @property
    def rig(self):
        return Rig(self.drive, ("jaw",), [(pad, {name: name}) for name, pad in self.pads.items()], self.clock)

    def measure(self, stated=STATED, most=MOST):
        return respond(self.rig.run(plan_sweep(stated, most), lambda _: None))


@pytest.mark.parametrize(
    ("gain", "offset", "delay", "play", "step", "error"),
    [
        (1.0, 0.0, 0.05, 0.0, 0.84, 0.005),
        (0.8, 3.0, 0.12, 2.0, 0.84, 0.005),
        (1.25, -4.0, 0.02, 1.0, 1.6, 0.03),  # steps that its map does not know, 3 % of the range
    ],
)
def test_gain_offset_delay_hysteresis_and_step_are_recovered(gain, offset, delay, play, step, error):
    found = Bench(gain=gain, offset=offset, delay=delay, play=play, step=step, seed=1).measure()
    assert found.gain.value == pytest.approx(gain, rel=error)
    assert found.felt(40.0) == pytest.approx(gain * 40.0 + offset, abs=gain * step)
    assert found.delay.value == pytest.approx(delay, abs=0.006)  # a pad is heard each 4 ms
    assert found.hysteresis.value == pytest.approx(play, abs=0.05)
    assert found.resolution.value == pytest.approx(gain * step, rel=0.05)


def test_a_drive_that_a_smaller_force_does_not_loosen_is_measured_as_it_rises():
    bench = Bench(gain=0.8, offset=3.0, step=0.84)
    bench.gripper.loosens = False
    found = bench.measure()
    assert not found.loosens
    assert found.felt(40.0) == pytest.approx(35.0, abs=0.8 * 0.84)  # no setting presses less than is believed
    assert found.gain.value == pytest.approx(0.8, rel=0.005)
    assert found.settings.keys() == {"delay"}


def test_the_delay_ends_at_half_of_the_step_of_a_force_loop():
    found = Bench(delay=0.04, lag=0.03).measure()
    assert found.delay.value == pytest.approx(0.04 + 0.03 * math.log(2.0), abs=0.006)


def test_a_drive_without_steps_has_none_and_says_how_fine_that_is_known():
    found = Bench(play=1.0).measure(replace(STATED, resolution=0.0))
    assert math.isnan(found.resolution.value)
    assert 0.0 < found.finer <= 0.3  # [N] of a 200th of 50 N
    assert "resolution" not in found.settings


def test_neither_a_setting_nor_a_force_is_above_what_is_allowed():
    bench = Bench(gain=1.3)
    found = bench.measure()
    assert max(bench.drive.told) <= MOST
    assert bench.gripper.largest <= MOST + 0.5
    assert found.range[1] < MOST
    assert found.gain.value == pytest.approx(1.3, rel=0.02)


def test_a_drive_that_presses_far_more_than_it_is_told_is_let_go():
    bench = Bench(gain=5.0)
    with pytest.raises(InputError, match="70 N allowed, so the jaws are opened"):
        bench.measure()


def test_it_takes_about_a_minute():
    bench = Bench()
    bench.measure()
    assert 40.0 < bench.clock.now() / NS < 75.0


def test_no_object_is_said():
    with pytest.raises(InputError, match="feel no object"):
        Bench(gain=0.0).measure()


def test_a_force_that_does_not_follow_is_no_drive():
    with pytest.raises(InputError, match="does not follow the settings"):
        Bench(gain=0.0, offset=30.0).measure()


def test_a_drive_later_than_its_settings_last_is_refused_with_what_to_state():
    with pytest.raises(InputError, match="state the drive's 'delay'"):
        Bench(delay=0.7).measure()
    assert Bench(delay=0.7).measure(replace(STATED, delay=0.5)).delay.value == pytest.approx(0.7, abs=0.006)


def test_a_silent_pad_and_a_fault_of_the_drive_end_the_run():
    with pytest.raises(DeviceError, match="pad of left is silent, so the jaws are opened"):
        Bench(dies=20.0).measure()
    bench = Bench()
    rig = bench.rig
    bench.drive.device_faults = frozenset({("gripper", "object_lost")})
    with pytest.raises(DeviceError, match="says of itself: object_lost; the jaws are opened"):
        rig.run(plan_sweep(STATED, MOST), lambda _: None)
    bench.drive.obeys = False
    with pytest.raises(DeviceError, match="object_lost; it takes no command, and its jaws stay"):
        rig.run(plan_sweep(STATED, MOST), lambda _: None)
    bench = Bench()
    rig = bench.rig
    bench.drive.rejected = {"silent": 1}
    with pytest.raises(DeviceError, match="the drive does not answer"):
        rig.run(plan_sweep(STATED, MOST), lambda _: None)
    bench = Bench()
    rig = bench.rig
    bench.drive.rejected = {"not_ready": 1}
    bench.drive.hints = {"not_ready": "it is no longer 'activated'"}
    with pytest.raises(DeviceError, match="the force cannot change: it is no longer 'activated'"):
        rig.run(plan_sweep(STATED, MOST), lambda _: None)


@pytest.mark.parametrize("scale", [0.1, 0.8, 1.25])
def test_pads_that_disagree_are_named_with_what_each_feels_and_not_averaged(scale):
    bench = Bench()
    bench.pads["left"].scale = scale
    said = rf"left {scale * 20:.0f}\.\d N and right [12]\d\.\d N are felt, unlike"
    with pytest.raises(InputError, match=said):
        bench.measure()
    bench.pads["left"].scale = 1.05  # as the gains of two pads may be
    assert bench.measure().gain.value == pytest.approx(1.025, rel=0.01)


def test_too_small_a_range_is_refused_with_the_least_that_does():
    with pytest.raises(UsageError, match=r"at least 27.56 N must be allowed"):
        plan_sweep(STATED, 25.0)


@pytest.mark.parametrize("product", ["robotiq-2f85", "robotiq-hand-e", "weiss-wsg50"])
def test_the_map_of_a_product_asks_for_what_is_felt_when_it_is_measured(product, tmp_path):
    source = read_source(f"{product}@there:1000", "")
    bench = Bench(gain=0.8, offset=2.0, delay=0.12, play=2.0)
    found = bench.measure(source.plan.hand.drive)
    path = tmp_path / "measured.toml"
    path.write_text(measured_map(source, measured_settings(source, found)))
    measured = read_source(str(path), "")
    assert measured.transport["address"] == "there:1000"
    laws = [law_of(each.plan.hand.fingers["jaw"].command, "", "") for each in (source, measured)]
    values = [law.sign * law.scale * law.per_newton for law in laws]
    sent = values[1] * 40.0 + laws[1].offset  # for 40 N that are to be felt
    told = (sent - laws[0].offset) / values[0]  # which the drive takes for a setting
    assert 0.8 * told + 2.0 == pytest.approx(40.0, abs=0.1)
    assert measured.plan.hand.drive.minimum == pytest.approx(
        0.8 * source.plan.hand.drive.minimum + 2.0, abs=0.1
    )


# the command


class Interrupted(SimulatedClock):
    """Ctrl-C after ``at`` [s]."""

    def __init__(self, at):
        super().__init__(NS)
        self.at = round(at * NS)

    def sleep_until(self, deadline):
        super().sleep_until(deadline)
        if self.now() >= self.at:
            self.at = 1 << 62
            raise KeyboardInterrupt


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    """Return a function that runs the command on a gripper, and gives exit code, output and the gripper."""
    path = write_bench(tmp_path)

    def run(*words, bench=None):
        bench = bench or Bench(gain=0.8, offset=3.0, delay=0.12, play=2.0, step=0.84)
        ends = {"left": bench.pads["left"], "right": bench.pads["right"], "gripper": bench.drive}
        monkeypatch.setattr(Source, "open", lambda self, _: ends[self.path.stem])
        monkeypatch.setattr("vegrip.cli._drive.WallClock", lambda: bench.clock)
        code = main(["calibrate", "--drive", str(path), *words])
        return code, capsys.readouterr(), bench

    return run


def test_a_copy_of_the_map_is_written_and_speaks_the_newtons_of_the_pads(command, tmp_path):
    before = (tmp_path / "gripper.toml").read_text()
    code, output, bench = command("--normal-force", "60", "--yes", "--json")
    assert code == 0, output.err
    assert (tmp_path / "gripper.toml").read_text() == before
    assert "fine" in output.err  # the progress
    assert bench.drive.told[-1] == 0.0
    assert all(each.closed for each in (bench.drive, *bench.pads.values()))
    written = tmp_path / "gripper-measured.toml"
    assert json.loads(output.out)["written"] == str(written)
    drive = tomllib.loads(written.read_text())["drive"]
    assert drive["delay"] == pytest.approx(0.12, abs=0.006)
    assert drive["hysteresis"] == pytest.approx(2.0, abs=0.05)
    assert drive["resolution"] == pytest.approx(0.8 * 0.84, rel=0.05)
    assert drive["minimum"] == pytest.approx(0.8 * 20.0 + 3.0, abs=0.7)
    law = read_source(str(written), "").plan.hand.fingers["gripper"].command
    asked = law.scale * 40.0 + law.offset  # of 40 N that are to be felt
    assert 0.8 * asked + 3.0 == pytest.approx(40.0, abs=0.7)


def test_nothing_is_overwritten_without_force(command, tmp_path):
    kept = tmp_path / "gripper-measured.toml"
    kept.write_text("mine")
    code, output, bench = command("--normal-force", "60", "--yes")
    assert (code, kept.read_text(), bench.drive.told) == (3, "mine", [])
    assert "--force" in output.err
    code, output, _ = command("--normal-force", "60", "--yes", "--force")
    assert (code, kept.read_text()) == (0, "mine"), output.err
    assert "measured by vegrip calibrate --drive" in (tmp_path / "gripper.toml").read_text()


def test_it_does_not_move_without_being_told_to(command):
    code, output, bench = command("--normal-force", "60")
    assert (code, bench.drive.told) == (2, [])
    assert "add --yes" in output.err


def test_more_than_the_launch_file_allows_is_refused(command, tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text(
        path.read_text() + '[[node]]\nprogram = "grasp_force"\nparameters.limits.max_force = 50.0\n'
    )
    code, output, bench = command("--normal-force", "60", "--yes")
    assert (code, bench.drive.told) == (2, [])
    assert "at most 50 N" in output.err


@pytest.mark.parametrize("bench", [Bench(Interrupted(30.0)), Bench(dies=30.0)], ids=["Ctrl-C", "a lost pad"])
def test_the_jaws_open_and_nothing_is_written_when_it_is_cut_short(command, tmp_path, bench):
    code, output, bench = command("--normal-force", "60", "--yes", bench=bench)
    assert code != 0
    assert "kept" not in output.err
    assert bench.drive.told[-1] == 0.0
    assert bench.gripper.force == pytest.approx(0.0, abs=1e-6)
    assert all(each.closed for each in (bench.drive, *bench.pads.values()))
    assert not (tmp_path / "gripper-measured.toml").exists()
