"""The other controllers of the demonstration, through the same scenario in simulated time.

Constant grip and cone run as tuned so that they did not slip on other scenarios, and again with the mean
force that vegrip took here. The first shows what their safety costs, the second what it was for. Where the
second slips, they run once more with the least force that slips no more than vegrip did.
"""

from vegrip.trials.candidates import KNOBS, LABEL
from vegrip.trials.closed_loop import Course, result_of, run_scenario
from vegrip.trials.scenario import Scenario

AS_FORCEFUL = ", same force"
"""Ends the name of a controller whose knob gives it the mean force of vegrip."""
SAME_FORCE = 0.01
"""Part of the force by which two mean forces may differ and still be called the same."""
AS_SURE = ", same slips"
"""Ends the name of a controller with the least knob at which it slips no more than vegrip."""
HALVINGS = 7  # in search of it
MOST_RUNS = 8  # in search of the knob


def label_of(name: str) -> str:
    base = name.removesuffix(AS_FORCEFUL).removesuffix(AS_SURE)
    return LABEL[base].removesuffix(" grip") + name[len(base) :] if base != name else LABEL[base]


def run_other_controllers(scenario: Scenario, ours: Course) -> dict[str, Course]:
    """Run constant grip and cone: as tuned, with the mean force of ``ours`` (thumb), and as sure."""
    tuned_knobs = {name: KNOBS[scenario.grasp][name] for name in ("constant", "cone")}
    knobs = dict(tuned_knobs)
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
    sure: dict[str, Course] = {}
    if not ours.dropped:
        for name in (name for name, course in same.items() if not is_as_sure(course, ours.slips)):
            if (knob := sure_knob(name, scenario, ours.slips, tuned_knobs[name])) is not None:
                sure[name + AS_SURE] = run_scenario(scenario, name, knob)
    return {**tuned, **{name + AS_FORCEFUL: course for name, course in same.items()}, **sure}


def is_as_sure(course: Course, slips: int) -> bool:
    return not course.dropped and course.slips <= slips


def sure_knob(name: str, scenario: Scenario, slips: int, enough: float) -> float | None:
    """Return the least knob with no more than ``slips``, by halving; None when ``enough`` slips more."""
    if not is_as_sure(run_scenario(scenario, name, enough), slips):
        return None
    too_low = 0.0
    for _ in range(HALVINGS):
        knob = 0.5 * (too_low + enough)
        if is_as_sure(run_scenario(scenario, name, knob), slips):
            enough = knob
        else:
            too_low = knob
    return enough


def force_ratio(theirs: Course, ours: Course) -> float:
    """Return the mean grip force of ``theirs`` over that of ``ours``, while both hold."""
    end = min(theirs.time[-1], ours.time[-1])
    return result_of(theirs, end).mean_grip_force / result_of(ours, end).mean_grip_force


def _run_all(knobs: dict[str, float], scenario: Scenario) -> dict[str, Course]:
    return {name: run_scenario(scenario, name, knob) for name, knob in knobs.items()}
