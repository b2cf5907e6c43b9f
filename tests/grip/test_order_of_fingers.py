"""What a grasp learns of slip and friction does not depend on the order in which its fingers stand.

All of it stands in one array. Three fingers feel loads, commands, slips and faults of their own; put
in other places, they leave the same numbers there.
"""

import math

import numpy as np
import pytest

from vegrip.grip import drive_lag, force_release, friction_belief, load_lead, slip_channels, slip_witness
from vegrip.grip.grasp_memory import BELIEF_MOST as MOST
from vegrip.grip.grasp_memory import BELIEF_ROW as ROW
from vegrip.grip.grasp_memory import PLACES, GraspMemory

BLOCKS = [(f"{section}_{name}".upper(), start, max(length, 1)) for section, name, start, length in PLACES]
DT, STEPS = 0.005, 2400  # [s]
SCRATCH = {"BELIEF_ALONG"}
CHANNELS = {f"SLIP_{name}" for name in ("SOUND", "SILENT", "SAYS", "SILENCE", "RATE", "ODDS", "SHOWS")}


def test_there_is_one_of_a_thing_for_the_grasp_or_some_for_each_finger() -> None:
    several = {name: length for name, _, length in BLOCKS if length not in (1, MOST)}
    assert several == {
        "BELIEF_MEAN": ROW, "BELIEF_ALONG": ROW, "BELIEF_P": ROW * ROW, "BELIEF_SAFE_MEAN": ROW,
        "BELIEF_SAFE_P": ROW * ROW, "DRIVE_STATE": 3 * MOST,
        "DRIVE_P": 9 * MOST, "LEAD_AHEAD": 3 * MOST, "LEAD_FAST": 3 * MOST, "LEAD_SLOW": 3 * MOST,
        **dict.fromkeys(CHANNELS, 2 * MOST),
    }  # fmt: skip


class Grasp:
    """Three fingers at given places."""

    def __init__(self, places: tuple[int, ...], delay: float) -> None:
        self.g, self.places = GraspMemory(), places
        g, n = self.g, len(places)
        friction_belief.begin_belief(g, n, 0.02)
        friction_belief.expect_exponent(g, 0.15, 0.0144)
        for finger, i in enumerate(places):
            friction_belief.expect_finger(g, i, math.log(0.7 + 0.05 * finger), 0.4 - 0.02 * finger, 0.08)
        drive_lag.begin_drives(g, 0.01)
        drive_lag.set_drives(g, 0.01, 4.0)
        load_lead.begin_lead(g, 0.01, 1e-4)
        slip_channels.begin_channels(g, 1e-3, delay)
        slip_witness.begin_witness(g, 0.002)
        force_release.begin_release(g)
        force_release.set_risk(g, 0.05, 0.24, True)
        self.answers: list[tuple[float, ...]] = []

    def feel(self, finger: int, felt: dict[str, float], touching: bool) -> None:
        """Take a sample of a finger as its step does."""
        g, i, u = self.g, self.places[finger], felt["u"]
        slip_channels.hear_slip(g, i, DT, felt["slip"], felt["speed"])
        drive_lag.follow_drive(g, i, DT, felt["command"], felt["force"])
        ahead = load_lead.lead_load(g, i, DT, felt["pull"], 0.3 * felt["pull"], 1e-3 * felt["pull"])
        g.belief.load[i] = load = math.log(felt["force"] / 5.0)
        g.belief.since += DT / len(self.places)
        slip_channels.follow_utilisation(g, i, DT, u, 0.02, load, touching)
        slip_witness.follow_forces(g, i, DT, felt["force"], felt["pull"], touching)
        changed = force_release.watch_quiet(g, i, DT, felt["pull"], 0.01, touching)
        force_release.note_slide(g, i, 0.02)
        force_release.decide(g, i, DT, 0.15, touching, changed)
        counts = g.release.counted[i], g.release.shift[i], g.slip.slides[i], g.slip.sound[i]
        self.answers.append((*ahead, *counts, slip_channels.noticed(g), drive_lag.measured_lag(g, i)))

    def places_of(self, name: str, start: int, length: int, finger: int) -> list[int]:
        """Return where a thing of a finger stands."""
        i, each = self.places[finger], length // MOST
        if name in {"BELIEF_P", "BELIEF_SAFE_P"}:
            return [start + i * ROW + j for j in (*self.places, len(self.places))]
        if name in CHANNELS:
            return [start + i, start + MOST + i]
        if length == ROW:
            return [start + i]
        return [start + each * i + k for k in range(max(each, 1))] if each else [start]


def felt_by(finger: int, seed: int) -> list[tuple[dict[str, float], bool]]:
    """Return what a finger feels: a load, a grip that is let go of, slips, gaps and false flags."""
    rng = np.random.default_rng([seed, finger])
    samples, force, quiet, slipping = [], 3.0, 0, 0
    for step in range(STEPS):
        t = DT * step
        command = 3.0 + 0.3 * finger + math.sin(2.0 * t + finger) - (1.5 if 2.5 < t % 4.0 < 2.9 else 0.0)
        force += (1.0 - math.exp(-DT / 0.02)) * (command - force)
        pull = 1.2 + 0.1 * finger + 0.3 * math.sin(0.7 * t) + (0.4 if t % 3.0 > 2.6 else 0.0)
        quiet -= 1
        if quiet < 0 and rng.random() < 0.01:
            quiet, slipping = int(rng.integers(10, 300)), int(rng.integers(1, 25))
        slipping -= 1
        slips = slipping >= 0
        speed = 2e-5 * (step % 3) if not slips or rng.random() < 0.3 else 5e-3
        lost = rng.random() < 0.003
        felt = {
            "command": math.nan if lost else command, "force": force + rng.normal(0.0, 0.005),
            "pull": max(pull + rng.normal(0.0, 0.002), 0.0),
            "slip": math.nan if lost else float(slips and rng.random() < 0.9), "speed": speed,
        }  # fmt: skip
        felt["u"] = felt["pull"] / felt["force"] if rng.random() > 0.01 else math.nan
        samples.append((felt, not (finger == 2 and 5.0 < t < 5.3)))
    return samples


@pytest.mark.parametrize(("delay", "seed"), [(0.0, 4), (0.03, 2), (0.02, 3)])
def test_fingers_in_other_places_learn_the_same(delay: float, seed: int) -> None:
    one, other = (Grasp(places, delay) for places in ((0, 1, 2), (2, 0, 1)))
    felt = [felt_by(finger, seed) for finger in range(3)]
    for step in range(STEPS):
        for grasp in (one, other):
            for finger in range(3):
                grasp.feel(finger, *felt[finger][step])
    assert any(answer[3] > 0.0 for answer in one.answers), "force is let go of"
    assert any(answer[4] > 0.9 for answer in one.answers), "fingers slide"
    np.testing.assert_allclose(other.answers, one.answers, rtol=1e-9, atol=1e-4)  # counted on: by halving
    for name, start, length in BLOCKS:
        if name in SCRATCH | {"SLIP_TEACHER"}:
            continue
        for finger in range(3 if length > 1 else 1):
            found, expected = (g.g.array[g.places_of(name, start, length, finger)] for g in (other, one))
            np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-10, err_msg=name)
