"""The other controllers of the demonstration, through the same scenario in simulated time.

Constant grip and cone run as tuned so that they did not slip on other scenarios, and again with the mean
force that vegrip took here. The first shows what their safety costs, the second what it was for.
"""

import math
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

from vegrip.c99 import host
from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.trials.candidates import KNOBS, LABEL, parameters
from vegrip.trials.closed_loop import Course, run_scenario
from vegrip.trials.compiled_loop import CompiledRun, run_compiled
from vegrip.trials.result import result_of
from vegrip.trials.scenario import Scenario
from vegrip.types import Floats

HERTZ_POWER = 1.0 / 3.0


def least_grip_force(course: Course) -> Floats:
    """Return the least possible grip force [N] at every time of ``course``; NaN without contact."""
    rows = [
        [_least(force, *contact) for force, contact in zip(forces, contacts, strict=True)]
        for forces, contacts in zip(course.force, course.contact, strict=True)
    ]
    if not rows:
        return np.zeros(0)
    each = np.array(rows)
    larger: Floats = np.maximum(each[:, 0], each[:, 1:].sum(axis=1))
    return larger


def force_over_least(course: Course, start: float) -> float:
    """Return the sum of the grip force over the sum of the least from ``start`` [s] on; NaN if never held."""
    least, force = least_grip_force(course), np.array([forces[0] for forces in course.force])
    counted = (np.array(course.time) >= start) & np.isfinite(least)
    if not counted.any() or not least[counted].sum() > 0.0:
        return math.nan
    return float(force[counted].sum() / least[counted].sum())


def _least(force: float, tangential: float, torque: float, mu: float, radius: float, k: float) -> float:
    if not (force > 0.0 and radius > 0.0):
        return math.nan
    return float(least_normal_force(tangential, torque, mu, radius, k, force, HERTZ_POWER, 0.0))


CONTACT = ("tangential", "torque", "mu", "radius", "exponent")
AS_FORCEFUL = ", same force"
"""Ends the name of a controller whose knob gives it the mean force of vegrip."""
SAME_FORCE = 0.01
"""Part of the force by which two mean forces may differ and still be called the same."""
MOST_RUNS = 8  # in search of the knob


def label_of(name: str) -> str:
    base = name.removesuffix(AS_FORCEFUL)
    return LABEL[base].removesuffix(" grip") + name[len(base) :] if base != name else LABEL[base]


def run_other_controllers(scenario: Scenario, ours: Course) -> dict[str, Course]:
    """Run constant grip and cone: as tuned, and with the mean force of ``ours`` (thumb)."""
    knobs = {name: KNOBS[scenario.grasp][name] for name in ("constant", "cone")}
    tuned = _run_all(knobs, scenario)
    same = dict(tuned)
    for _ in range(MOST_RUNS):
        ratios = {name: force_ratio(course, ours) for name, course in same.items()}
        off = {name: ratio for name, ratio in ratios.items() if abs(ratio - 1.0) > SAME_FORCE}
        if not off:
            break
        for name, ratio in off.items():  # a cone's force goes with 1 + safety
            least = 1.0 if name == "cone" else 0.0
            knobs[name] = max((least + knobs[name]) / ratio - least, 0.0)
        same |= _run_all({name: knobs[name] for name in off}, scenario)
    return {**tuned, **{name + AS_FORCEFUL: course for name, course in same.items()}}


def force_ratio(theirs: Course, ours: Course) -> float:
    end = min(theirs.time[-1], ours.time[-1])
    return result_of(theirs, end).mean_grip_force / result_of(ours, end).mean_grip_force


def _run_all(knobs: dict[str, float], scenario: Scenario) -> dict[str, Course]:
    if host.compiler() is not None:
        return {name: compiled_course(name, knob, scenario) for name, knob in knobs.items()}
    with ProcessPoolExecutor(len(knobs)) as pool:
        courses = pool.map(partial(run_scenario, scenario), knobs, knobs.values())
        return dict(zip(knobs, courses, strict=True))


def compiled_course(name: str, knob: float, scenario: Scenario) -> Course:
    settings = parameters(name, knob)
    run = run_compiled(scenario.settings, scenario.seed, scenario.events, settings, scenario.duration)
    return course_of(run)


def course_of(run: CompiledRun) -> Course:
    """Return a compiled run in the form of the uncompiled one."""
    truth = run.truth
    columns = [truth[name].tolist() for name in CONTACT]
    return Course(
        run.fingers,
        slips=run.slips,
        dropped=run.dropped,
        time=run.time.tolist(),
        margin=truth["margin"].tolist(),
        force=truth["force"].tolist(),
        command=truth["command"].tolist(),
        slipped=[int(count) for count in run.slipped],
        contact=[[tuple(values) for values in zip(*row, strict=True)] for row in zip(*columns, strict=True)],
    )
