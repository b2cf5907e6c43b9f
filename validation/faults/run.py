"""Runs a case and tells what happened, next to what would have happened without the fault."""

import functools
import tempfile
from dataclasses import dataclass
from pathlib import Path

from validation.faults.table import FAULT_BEGIN_S, Case
from validation.faults.testbed import SAMPLING, Course, FickleWriter, Scene
from vegrip.messages import Condition

WATCHED_AFTER_S = 1.0  # [s] that a case goes on after its fault
EQUAL_SHARE, EQUAL_N = 0.02, 0.03  # [-], [N] by which two forces count as equal: noise of the loop
FAIL_SAFE = 5.0  # [N] fail_safe.force


@dataclass(frozen=True)
class Outcome:
    """What happened."""

    case: Case
    detected_after: float | None  # [s] after the beginning; None: not seen
    seen_as: frozenset[Condition]
    recovered_after: float | None  # [s] after the end; None: not until the end of the run
    worst_deficit: float  # [N] by which the true grip was below what it must not be below; <= 0 is well
    worst_at: float  # [s] after the beginning
    least: float  # [N] true force of a finger from the beginning on
    most: float  # [N]
    worst_surplus: float  # [N] by which it was above what a fault may raise it to; <= 0 is well
    slips: int
    dropped: bool
    counted: int  # under the case's name
    received: int  # messages of the recorder
    recorded: int  # of them on disk

    def complaints(self) -> list[str]:
        """Return what is not as it must be, in sentences."""
        case, found = self.case, []
        if case.seen_as and not self.seen_as & case.seen_as:
            found.append(f"it was not seen as {_names(case.seen_as)} but as {_names(self.seen_as)}")
        if case.seen_as and (self.detected_after is None or self.detected_after > case.detection + SAMPLING):
            found.append(f"it was seen after {self.detected_after} s, not within {case.detection:g} s")
        if self.recovered_after is None or self.recovered_after > case.recovery + SAMPLING:
            found.append(f"it was over after {self.recovered_after} s, not within {case.recovery:g} s")
        if self.worst_deficit > 0.0:
            found.append(f"the grip was {self.worst_deficit:.3f} N too low {self.worst_at:.2f} s into it")
        if self.worst_surplus > 0.0:
            found.append(f"the grip was raised {self.worst_surplus:.3f} N too far")
        if self.slips or self.dropped:
            found.append(f"{self.slips} slips, {'the object was dropped' if self.dropped else 'not dropped'}")
        if case.counted_as and not self.counted:
            found.append(f"nothing was counted as {case.counted_as}")
        if self.recorded != self.received:
            found.append(f"{self.received} messages were received and {self.recorded} recorded")
        return found


def run(case: Case) -> Outcome:
    """Run ``case`` and the same without it."""
    with tempfile.TemporaryDirectory(prefix="vegrip-") as folder:
        return _run(case, Path(folder) / "recording")


def _run(case: Case, folder: Path) -> Outcome:
    writer = FickleWriter(folder)
    scene = Scene(writer=writer, sender_time=case.sender_time)
    scene.run_until(FAULT_BEGIN_S)
    fault = case.make()
    grip = scene.grip
    fault.begin(scene)
    scene.run_until(FAULT_BEGIN_S + case.duration)
    fault.end(scene)
    scene.run_until(FAULT_BEGIN_S + case.duration + WATCHED_AFTER_S)
    writer.close()
    course, reference = scene.course, undisturbed(FAULT_BEGIN_S + case.duration + WATCHED_AFTER_S)
    detected, seen = _detection(course)
    deficit, at = _deficit(course, reference, case)
    counted = {**grip.endpoint.rejected, **grip.node.rejected}
    received = scene.recorder.received if scene.recorder is not None else 0
    return Outcome(
        case=case,
        detected_after=detected,
        seen_as=seen,
        recovered_after=_recovery(course, FAULT_BEGIN_S + case.duration),
        worst_deficit=deficit,
        worst_at=at,
        least=min(min(force) for force in course.force[_sample(FAULT_BEGIN_S) :]),
        most=max(max(force) for force in course.force[_sample(FAULT_BEGIN_S) :]),
        worst_surplus=_surplus(course, reference, FAIL_SAFE * (1.0 + case.anew)),
        slips=scene.hand_node.hand.slips,
        dropped=scene.hand_node.hand.dropped,
        counted=counted.get(case.counted_as, 0),
        received=received,
        recorded=_rows_on_disk(folder),
    )


@functools.cache
def _undisturbed_scene() -> Scene:
    return Scene()


def undisturbed(until: float) -> Course:
    """Return the course of the same hand without a fault, up to ``until`` [s] at least."""
    scene = _undisturbed_scene()
    scene.run_until(until)
    return scene.course


def floor(course: Course, reference: Course, i: int, finger: int, relaxes: float) -> float:
    """Return what the true grip of a finger must not be below at sample ``i`` [N].

    What it was when the fault began, what it would be without the fault, or the fail-safe grip: the least of
    them. Where the hand is left alone with its position, the soft tip relaxes by the share ``relaxes``.
    """
    onset = course.force[_sample(FAULT_BEGIN_S)][finger]
    least = min(onset, reference.force[i][finger], FAIL_SAFE)
    return least * (1.0 - EQUAL_SHARE - relaxes) - EQUAL_N


def _deficit(course: Course, reference: Course, case: Case) -> tuple[float, float]:
    worst, at = -1.0, 0.0
    for i in range(_sample(FAULT_BEGIN_S), len(course.time)):
        for finger, force in enumerate(course.force[i]):
            deficit = floor(course, reference, i, finger, case.relaxes) - force
            if deficit > worst:
                worst, at = deficit, course.time[i] - FAULT_BEGIN_S
    return worst, at


def _surplus(course: Course, reference: Course, allowed: float) -> float:
    """Return by how much a grip exceeds what it was, would be, and what is ``allowed`` [N], at worst [N]."""
    begin, worst = _sample(FAULT_BEGIN_S), -1.0
    for i in range(begin, len(course.time)):
        for finger, force in enumerate(course.force[i]):
            usual = max(course.force[begin][finger], reference.force[i][finger], allowed)
            worst = max(worst, force - usual * (1.0 + EQUAL_SHARE) - EQUAL_N)
    return worst


def _detection(course: Course) -> tuple[float | None, frozenset[Condition]]:
    first: float | None = None
    seen: set[Condition] = set()
    for i in range(_sample(FAULT_BEGIN_S), len(course.time)):
        bad = {condition for condition in course.condition[i] if condition is not Condition.OK}
        if bad and first is None:
            first = course.time[i] - FAULT_BEGIN_S
        seen |= bad
    return first, frozenset(seen)


def _recovery(course: Course, end: float) -> float | None:
    """Return after which time all fingers are OK and obey valid commands for the rest of the run."""
    well: float | None = None
    for i in range(len(course.time) - 1, _sample(end) - 1, -1):
        ok = all(condition is Condition.OK for condition in course.condition[i]) and course.obeyed[i]
        if not ok:
            break
        well = course.time[i] - end
    return well


def _sample(time: float) -> int:
    return round(time / SAMPLING) - 1


def _rows_on_disk(folder: Path) -> int:
    return sum(_rows(path.read_bytes()) for path in folder.rglob("*.csv"))


def _rows(text: bytes) -> int:
    return max(text.count(b"\n") - 1, 0)


def _names(conditions: frozenset[Condition]) -> str:
    return ", ".join(sorted(condition.name for condition in conditions)) or "nothing"
