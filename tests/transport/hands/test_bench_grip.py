"""A bench in simulated time: an object is held by whole steps of a drive, whatever part of the bench dies."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.config import build
from vegrip.demo.bench import BenchScenario, open_bench_product
from vegrip.grip.parameters import GraspParameters
from vegrip.grip.safety.drive import DriveLimits
from vegrip.messages import FingertipState, ForceCommand
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.endpoint import NONE_BROKEN, Endpoint
from vegrip.transport.hands.bench_endpoint import BenchEndpoint, Drive, Part
from vegrip.trials.closed_loop import PERIOD_S, SAMPLING_S, Course, grip_of
from vegrip.virtual import VirtualHand

ROBOTIQ = DriveLimits(resolution=0.843, rate=25.0, delay=0.05, minimum=20.0, maximum=60.0, hysteresis=1.7)
JAWS = ("left", "right")
pytestmark = pytest.mark.slow


class Line(Endpoint):
    """A part of the bench in the time of the test."""

    rejected = NONE_BROKEN  # nothing goes wrong

    def __init__(self):
        self.coming, self.told = [], math.nan

    def receive(self, timeout):  # noqa: ARG002
        found, self.coming = self.coming, []
        self.arrivals = [0] * len(found)
        return found

    def send(self, message):
        if isinstance(message, ForceCommand):
            self.told = message.normal_force

    def close(self):
        pass


class Run:
    """A virtual gripper, its bench and the grip controller; parts in ``dead`` are neither heard nor obey."""

    def __init__(self, folder, seed, *, disturbed=True, duration=12.0):
        scenario = BenchScenario(seed, duration, "pinch", relaxes_slowly=False, names=JAWS)
        self.product = product = open_bench_product("papillarray+robotiq", folder)
        self.course = Course(JAWS)
        self.hand = VirtualHand(scenario.settings, seed, scenario.events if disturbed else ())
        self.grip = grip_of(replace(product.parameters(scenario), suspects=False), JAWS)
        self.lines = {name: Line() for name in (*JAWS, "drive")}
        pads = [Part(name, name, self.lines[name], {name: name}) for name in JAWS]
        driven = Part("drive", "drive", self.lines["drive"], {"jaw": "jaw"}, "drive")
        drive = Drive(driven, ("jaw",), JAWS, ROBOTIQ)
        self.bench, self.dead, self.force, self.told = (
            BenchEndpoint([*pads, driven], [drive]),
            set(),
            math.nan,
            [],
        )

    def until(self, time):
        """Go on to ``time`` [s] of the hand; keep what the drive is told."""
        while self.hand.time < time and not self.hand.dropped:
            now = round(self.hand.time * NS) + NS
            for sample in self.hand.advance(PERIOD_S, np.full(2, self.force)):
                for state in sample.states(JAWS):
                    if state.finger not in self.dead:
                        self.lines[state.finger].coming.append(state._replace(stamp=now))
            for command in self.grip.step(self.bench.receive(0.0), now):
                self.bench.send(command)
            if "drive" not in self.dead:
                self.force = self.lines["drive"].told
            self.told.append(self.force)
            if self.hand.time >= len(self.course.time) * SAMPLING_S:
                self.course.sample(self.hand, (self.force, self.force))
        return self

    @property
    def slid(self):
        return max(self.hand.truth(finger).slip_distance for finger in JAWS)


@pytest.mark.parametrize("seed", [pytest.param(1, marks=pytest.mark.long), 2])
def test_a_bench_holds_by_whole_steps_of_its_drive_and_little_above_the_best_of_them(tmp_path, seed):
    run = Run(tmp_path, seed, duration=20.0).until(20.0)
    assert run.product.figures(run.course)["force_over_best"] <= 1.3
    assert not run.hand.dropped
    assert run.slid < 1e-3
    steps = [(force - 20.0) / 0.843 for force in run.told if not math.isnan(force)]
    assert all(math.isclose(step, round(step), abs_tol=1e-6) for step in steps)


@pytest.mark.parametrize("dead", [{"left"}, {"left", "right"}, {"drive"}])
def test_whatever_dies_while_it_is_shaken_nothing_is_let_go_of(tmp_path, dead):
    run = Run(tmp_path, 2).until(4.5)
    before = run.force
    run.dead |= dead
    run.until(12.0)
    assert not run.hand.dropped
    if "drive" in dead:
        assert run.force == before
    elif dead == set(JAWS):
        assert min(run.told[-3500:]) >= before


def usual_grip(folder):
    """Return the grip of a bench of which friction, radius and the largest force are stated."""
    path = folder / "bench.toml"
    path.write_text(
        f'sensors = ["left=contactile-papillarray@{folder}/l", "right=contactile-papillarray@{folder}/r"]\n'
        f'drive = "robotiq-2f85@{folder}/d"\n[[node]]\nprogram = "grasp_force"\n[node.parameters]\n'
        "limits.max_force = 60.0\ntip.radius = 8e-3\n"
        "friction.coefficient = 0.6\nfriction.coefficient_std = 0.1\n"
    )
    (node,) = read_launch_file(path)
    return grip_of(replace(build(GraspParameters, node.parameters, ""), suspects=False), JAWS)


@pytest.mark.parametrize(
    ("begin", "gap"), [(8.0, 3.0), (60.0, 0.0)], ids=["a pad comes back", "at its limit"]
)
def test_what_is_far_too_much_is_let_down_again(tmp_path, begin, gap):
    grip, noise = usual_grip(tmp_path), np.random.default_rng(1)
    force, told = begin, dict.fromkeys(JAWS, begin)
    for number in range(6000):
        t, now = number / 500, NS + number * NS // 500
        load = 2.0 if t < 2.0 else 5.0
        states = [
            FingertipState(
                now, finger, number, force + 0.02 * noise.normal(), 0.0, 0.01 * noise.normal() - load, 0.0
            )
            for finger in JAWS
            if finger == "left" or not 2.0 < t < 2.0 + gap
        ]
        told |= {
            each.finger: each.normal_force
            for each in grip.step(states, now)
            if isinstance(each, ForceCommand)
        }
        force += 0.01 * (max(told.values()) - force)
    assert load / 0.6 < force < 3.0 * load / 0.6  # was 60 N, for ever


@pytest.mark.long
def test_under_a_constant_load_the_drive_is_told_another_force_once_in_ten_seconds_at_most(tmp_path):
    run = Run(tmp_path, 3, disturbed=False, duration=30.0).until(30.0)
    told = run.told[2500:]  # from five seconds on it is lifted and quiet
    changes = [number * PERIOD_S for number in range(1, len(told)) if told[number] != told[number - 1]]
    assert all(after - before >= 10.0 for before, after in itertools.pairwise(changes))
