"""What must hold whatever goes over the wire.

* The command is a number within the limits, always.
* It never falls below 0.95 of what it was before the fault, or would be without it, the less of both.
* 2 s after a fault of the frames all is as usual: commands in force, condition OK, not held or fail-safe, and
  the force not above 1.5 of what it would be (it comes down from the fail-safe grip slowly). A wrong value
  may have raised it to its largest and has 4 s for this; but it is not there for more than 0.5 s after it.
* What was refused is counted under its name; what cannot be believed is told as a condition.
"""

from functools import cache

from faults import BEGIN, DURATIONS, KINDS, LONG, NOT_SENSED, SPREAD, Case, Injection
from rig import PERIOD, Course, Rig

FALLEN = 0.95
ROUNDING = 1e-3  # [N]
BACK, BACK_OF_VALUES = 2.0, 4.0  # [s]
MAXIMUM = 0.5  # [s]
AS_USUAL = 1.5  # [-] of the command without the fault: what it may still be above it
HELD = (8, 9, 10)  # reasons: held, fail-safe, untrusted
END = BEGIN + SPREAD + max(DURATIONS.values()) + BACK_OF_VALUES + 0.2  # [s] of the longest run
DEGRADED = 1


@cache
def undisturbed(wire: str) -> Course:
    """Return the grasp without a fault."""
    rig = Rig(wire)
    rig.run_until(END)
    return rig.course


def complaints(case: Case, make: type[Rig] = Rig) -> list[str]:
    """Run ``case`` and return what is not as it must be, in sentences."""
    rig = make(case.wire)
    rig.fault = injection = Injection(case, rig)
    rig.run_until(case.end + (BACK_OF_VALUES if case.of_values else BACK))
    return [
        *_limits(rig),
        *_fallen(rig, case),
        *_back(rig, case),
        *_told(rig, case, injection.met),
    ]


def _limits(rig: Rig) -> list[str]:
    found, limits = [], rig.limits
    low, high = limits.min_force * (1.0 - 1e-6), limits.max_force * (1.0 + 1e-6)
    if any(not low <= force <= high for forces in rig.course.force[1:] for force in forces):
        found.append("a command is not a number within the limits")
    if rig.course.broken:
        found.append(f"{rig.course.broken} messages of the node cannot be read")
    return found


def _fallen(rig: Rig, case: Case) -> list[str]:
    without, begin = undisturbed(case.wire).force, round(case.begin / PERIOD)
    before = rig.course.force[begin - 1]
    for i, forces in enumerate(rig.course.force[begin:], begin):
        for finger, force in enumerate(forces):
            floor = FALLEN * min(before[finger], without[i][finger]) - ROUNDING
            if not force >= floor:
                after = i * PERIOD - case.begin
                return [f"finger {finger} is told {force:.3f} N, not {floor:.3f} N, {after:.3f} s into it"]
    return []


def _back(rig: Rig, case: Case) -> list[str]:
    course, over = rig.course, round(case.end / PERIOD)
    found = []
    if not course.obeyed[-1]:
        found.append("commands have expired")
    tolerated = DEGRADED if case.what in NOT_SENSED else 0  # it was there and has gone again
    if any(condition > tolerated for condition in course.condition[-1]):
        found.append(f"conditions in the end: {course.condition[-1]}")
    if any(reason in HELD for reason in course.reason[-1]):
        found.append(f"reasons in the end: {course.reason[-1]}")
    usual = undisturbed(case.wire).force[len(course.force) - 1]
    if any(force > AS_USUAL * u for force, u in zip(course.force[-1], usual, strict=True)):
        found.append(f"commands in the end: {course.force[-1]} N, {usual} N without it")
    at_most = sum(max(forces) >= 0.999 * rig.limits.max_force for forces in course.force[over:])
    if at_most * PERIOD > MAXIMUM:
        found.append(f"{at_most * PERIOD:.2f} s at the largest force after it")
    return found


def _told(rig: Rig, case: Case, met: int) -> list[str]:
    if case.of_values or not met:
        return []
    expected = getattr(KINDS[case.what], case.wire)
    if isinstance(expected, int):
        begin = round(case.begin / PERIOD)
        seen = {c for conditions in rig.course.condition[begin:] for c in conditions}
        lasts = case.duration >= LONG and case.share == 1.0
        return [f"not told as condition {expected}"] if lasts and expected not in seen else []
    counts = rig.course.counts[-1]
    late = case.what == "reversed" and met < 8  # too few to be turned round
    if expected and not late and not any(counts.get(name, 0) for name in expected.split()):
        return [f"not counted as {expected}, but { ({n: c for n, c in counts.items() if c}) }"]
    return []
