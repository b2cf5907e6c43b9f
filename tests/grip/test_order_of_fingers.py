"""What a grasp learns of slip and friction does not depend on the order in which its fingers stand.

All of it stands in one array. Three fingers feel loads, commands, slips and faults of their own; put
in other places, they leave the same numbers there.
"""

import math

import numpy as np
import pytest

from vegrip.grip import slip_trust as friction
from vegrip.grip.grasp_memory import BELIEF_MOST as MOST
from vegrip.grip.grasp_memory import PLACES, GraspMemory

BLOCKS = [(f"{section}_{name}".upper(), start, max(length, 1)) for section, name, start, length in PLACES]
DT, STEPS, STIRRED = 0.005, 1200, 12  # [s], and after so many steps the grasp is found in another state


MARKS = {"DRIVE_KNOWN", "DRIVE_BEGUN", "LEAD_BEGUN", "ONSET_SILENT", "LATE_ENDED", "TRUST_VOID"}
ALL = {"TRUST_GRIP", "TRUST_LOAD", "TRUST_FIRST", "TRUST_LATER", "TRUST_NOISY"}  # never 0
STATES = MARKS | ALL | {
    "PROBE_SINCE_SLIP", "PROBE_SHIFT", "PROBE_LOAD", "PROBE_SMOOTH", "PROBE_STILL", "ONSET_RUN", "ONSET_SUM",
    "ONSET_QUIET", "ONSET_HELD", "ONSET_DOUBTED", "DRIVE_LAG", "DRIVE_WAIT", "DRIVE_MOVED", "DRIVE_MISFIT",
    "DRIVE_SEEN", "FELT_QUIET", "FELT_BEGAN", "FELT_LOW", "FELT_OVER", "FELT_AGAINST", "FELT_OFF",
    "FELT_WHY", "FELT_LIVE", "LATE_AGE", "LATE_PAST", "CHANGE_LEVEL", "CHANGE_SPREAD",
    "TRUST_HELD", "TRUST_LEAST", "TRUST_FELL", "TRUST_WAIT", "TRUST_MISSED", "TRUST_RATIO", "TRUST_TORN",
    "TRUST_PROOF", "TRUST_TOP", "TRUST_PULL", "TRUST_FORCE", "TRUST_CONSTANT", "TRUST_FALSE", "TRUST_RIM",
    "TRUST_KEPT", "TRUST_CLEAN", "TRUST_MEAN", "TRUST_TOLD",
}  # fmt: skip
SIZES = {
    "ONSET_DOUBTED": 4.0, "TRUST_CONSTANT": 60.0, "TRUST_FALSE": 4.0, "DRIVE_MOVED": 8.0, "DRIVE_LAG": 0.1,
    "TRUST_GRIP": 9.0, "TRUST_FIRST": 9.0, "TRUST_LATER": 9.0, "TRUST_WAIT": 0.02, "TRUST_RIM": 0.1,
    "FELT_WHY": 4.0, "FELT_LIVE": 4.0,
}  # fmt: skip


def test_there_is_one_of_a_thing_for_the_grasp_or_some_for_each_finger() -> None:
    several = {name: length // MOST for name, _, length in BLOCKS if length not in (1, MOST)}
    felt = dict.fromkeys((name for name in several if name.startswith("FELT_")), 2)
    assert several == {
        "BELIEF_P": MOST, "DRIVE_STATE": 3, "DRIVE_P": 9, "LEAD_AHEAD": 3, "LEAD_FAST": 3, "LEAD_SLOW": 3,
        "LATE_PAST": 8, **felt,
    }  # fmt: skip


class Grasp:
    """Three fingers at given places."""

    def __init__(self, places: tuple[int, ...], delay: float, unknown: float) -> None:
        self.g, self.places = GraspMemory(), places
        g, n = self.g, len(places)
        friction.begin_belief(g, n, 0.02, 0.08)
        for finger, i in enumerate(places):
            friction.expect_finger(g, i, math.log(0.7 + 0.05 * finger), 0.4 - 0.02 * finger, 0.08)
        friction.begin_probing(g, 2.0, 0.6, unknown, 0.06, 0.2, 0.05, 0.5, 2.0)
        friction.begin_onsets(g, 0.1, 0.08)
        friction.begin_drives(g, 0.01)
        friction.tell_drives(g, 0.01, True, 4.0)
        friction.begin_lead(g, 0.01, 1e-4)
        friction.begin_felt_slip(g, 1e-3, delay)
        friction.begin_late_slip(g)
        friction.begin_changes(g)
        friction.begin_trust(g)
        self.answers: list[tuple[float, ...]] = []

    def feel(self, finger: int, felt: dict[str, float], touching: bool) -> None:
        """Take a sample of a finger as its step does."""
        g, i, u = self.g, self.places[finger], felt["u"]
        friction.follow_drive(g, i, DT, felt["command"], felt["force"])
        ahead = friction.lead_load(g, i, DT, felt["pull"], 0.3 * felt["pull"], 1e-3 * felt["pull"])
        flag = friction.believed_flag(g, i, felt["slip"])
        speed = friction.believed_speed(g, i, felt["speed"])
        then = friction.recall_load(g, i, DT, u)
        friction.feel_onset(g, i, DT, then, 0.05 if friction.may_teach(g, i) else math.inf, flag, speed)
        friction.watch_load(g, i, DT, felt["pull"], 0.01, touching)
        slides = friction.ends_probe(g, i, DT, flag >= 1.0, friction.shows_sliding(g, speed))
        friction.follow_trust(
            g, i, DT, flag, felt["speed"], then, 0.05, felt["force"], felt["pull"], 0.002, touching
        )
        friction.feel_slip(g, DT, len(self.places), slides)
        friction.let_go(g, i, DT, 1.0, 0.1, u, 0.002, touching, slides)
        friction.judge_felt_slip(g, i, DT, felt["slip"], felt["speed"], u, 0.1)
        friction.follow_level(g, i, DT)
        if felt["slip"] == 1.0 and friction.is_witnessed(g, i) and u > 0.0:
            friction.absorb_evidence(g, i, g.belief.mean[i], 0.1, math.log(u), 0.01)
        known = friction.counts_as_known(g, i), friction.present_slip(g, i, speed)
        bound = friction.counted_shift(g, i, 1.5), friction.measured_lag(g, i)
        self.answers.append((*ahead, flag, speed, then, *known, *bound))

    def places_of(self, name: str, start: int, length: int, finger: int) -> list[int]:
        """Return where a thing of a finger stands."""
        i, each = self.places[finger], length // MOST
        if name == "BELIEF_P":
            return [start + i * MOST + j for j in self.places]
        if name.startswith("FELT_") and each:
            return [start + i, start + MOST + i]
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


def stir(grasps: tuple[Grasp, Grasp], rng: np.random.Generator) -> None:
    """Put both grasps into the same state, whichever."""
    for name, start, length in BLOCKS:
        if name not in STATES:
            continue
        size = (1, 1) if length == 1 else (3, length // MOST)
        values = rng.choice([0.0, 0.2, 1.0], size) * SIZES.get(name, 1.0) * rng.uniform(0.1, 1.0, size)
        if name in MARKS:
            values = rng.integers(0, 2, size).astype(float)
        elif name in ALL:
            values = SIZES.get(name, 1.0) * rng.uniform(0.1, 1.0, size)
        if name == "TRUST_NOISY":  # else the first finger, the thumb, has a part of its own
            values += friction.TRUST_LIVELY
        if name in ("ONSET_RUN", "PROBE_STILL", "TRUST_LEAST"):
            other = {"ONSET_RUN": -2.0, "PROBE_STILL": -1.0, "TRUST_LEAST": math.inf}[name]
            values = np.where(
                rng.random(size) < 0.3, other, values.round() if name == "ONSET_RUN" else values
            )
        for grasp in grasps:
            for finger in range(size[0]):
                grasp.g.array[grasp.places_of(name, start, length, finger)] = values[finger]


@pytest.mark.parametrize(("delay", "unknown", "seed"), [(0.0, 0.2, 1), (0.03, 0.5, 2)])
def test_fingers_in_other_places_learn_the_same(delay: float, unknown: float, seed: int) -> None:
    one, other = (Grasp(places, delay, unknown) for places in ((0, 1, 2), (2, 0, 1)))
    felt, rng = [felt_by(finger, seed) for finger in range(3)], np.random.default_rng(seed)
    for step in range(STEPS):
        if step % STIRRED == 0 and step > STEPS // 2:
            stir((one, other), rng)
        for grasp in (one, other):
            for finger in range(3):
                grasp.feel(finger, *felt[finger][step])
    np.testing.assert_allclose(other.answers, one.answers, rtol=1e-9, atol=1e-12)
    for name, start, length in BLOCKS:
        for finger in range(3 if length > 1 else 1):
            found, expected = (g.g.array[g.places_of(name, start, length, finger)] for g in (other, one))
            np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-10, err_msg=name)
