"""The other controllers of the demonstration, through the same scenario in simulated time.

Constant grip and cone run twice: as tuned so that they did not slip on other scenarios, and with about the
mean force that vegrip took here. The first shows what their safety costs, the second what it was for.
"""

from concurrent.futures import ProcessPoolExecutor

from vegrip.c99 import host
from vegrip.validation.controllers.candidates import KNOBS, LABEL, parameters
from vegrip.validation.controllers.closed_loop import Course
from vegrip.validation.controllers.comparison import Trial, run_course
from vegrip.validation.controllers.compiled_loop import CompiledRun, run_compiled
from vegrip.validation.controllers.result import result_of
from vegrip.validation.controllers.scenario import Scenario

CONTACT = ("tangential", "torque", "mu", "radius", "exponent")
AS_FORCEFUL = ", same force"
"""Ends the name of a controller whose knob gives it about the mean force of vegrip."""


def label_of(name: str) -> str:
    """Return what a controller is called in tables and sentences."""
    base = name.removesuffix(AS_FORCEFUL)
    return LABEL[base].removesuffix(" grip") + name[len(base) :] if base != name else LABEL[base]


def run_other_controllers(scenario: Scenario, mean_force: float) -> dict[str, Course]:
    """Run constant grip and cone, as tuned and with about ``mean_force`` [N] of the first finger."""
    knobs = KNOBS[scenario.grasp]
    tuned = _run_all({name: knobs[name] for name in ("constant", "cone")}, scenario)
    fingers = len(scenario.settings.fingers) - 1
    cone = result_of(tuned["cone"]).mean_grip_force
    same = {
        "constant": mean_force / fingers,
        "cone": max((1.0 + knobs["cone"]) * mean_force / cone - 1.0, 0.0),
    }
    lighter = _run_all(same, scenario)
    return {**tuned, **{name + AS_FORCEFUL: course for name, course in lighter.items()}}


def _run_all(knobs: dict[str, float], scenario: Scenario) -> dict[str, Course]:
    if host.compiler() is not None:
        return {name: _compiled(name, knob, scenario) for name, knob in knobs.items()}
    trials = [Trial(n, scenario.seed, scenario.duration, knob, scenario.grasp) for n, knob in knobs.items()]
    with ProcessPoolExecutor(len(trials)) as pool:
        return dict(zip(knobs, pool.map(run_course, trials), strict=True))


def _compiled(name: str, knob: float, scenario: Scenario) -> Course:
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
