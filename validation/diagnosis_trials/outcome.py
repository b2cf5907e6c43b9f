"""What came of a case, and whether it is right."""

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from validation.diagnosis_trials.blind import truth_of
from validation.diagnosis_trials.cases import Case, make_recording
from validation.diagnosis_trials.faults import Faults
from validation.diagnosis_trials.visible import VISIBLE_NATS, remaining_evidence
from vegrip.identification.blind import Answer
from vegrip.identification.diagnosis.diagnosis import diagnose

NEAR_FLOOR = 1.05  # times the noise


@dataclass(frozen=True)
class Outcome:
    """What was said of one recording.

    Attributes:
        case: what was hidden.
        verdict: of the diagnosis.
        named: effects.
        sets: of effects that were not told apart.
        variable: over which what is left is a curve, empty where noise is left.
        before, after: rms of standardised residuals of the refitted paper's model, and of the last one.
        misfit: chi-square per regime of both.
        seconds: of processor time.
        leaves: what each hidden effect by itself leaves [nats], see
            :mod:`validation.diagnosis_trials.visible`.

    """

    case: Case
    verdict: str
    named: tuple[str, ...]
    sets: tuple[tuple[str, ...], ...]
    variable: str
    before: float
    after: float
    misfit: tuple[float, float]
    seconds: float
    leaves: Mapping[str, float] = field(default_factory=dict)

    @property
    def visible(self) -> frozenset[str]:
        """What is hidden and can be seen in the recording."""
        return frozenset(name for name in self.case.hidden if self.leaves.get(name, math.inf) >= VISIBLE_NATS)

    @property
    def out_of_sight(self) -> bool:
        """Whether something is hidden that the recording cannot show."""
        return bool(self.case.hidden) and not self.visible

    @property
    def answer(self) -> str:
        """right, set (one that holds it), missed, partly, wrong, unexplained, other variable."""
        many = self.case.places > 1 or self.case.faults.leave_misfit
        if self.case.kind == "none" and many:  # none is missing, and no one law explains it
            return "right" if self.verdict in ("adequate", "unexplained") else "wrong"
        unsure = {name for group in self.sets for name in group}
        sure = tuple(name for name in self.named if name not in unsure)
        truth = truth_of(self.case, self.visible)
        return Answer(self.verdict, sure, self.sets, self.variable).grade(truth)

    @property
    def right(self) -> bool:
        """Whether exactly what is hidden was named, or a set that holds it; outside, the right variable."""
        return self.answer in ("right", "set")

    @property
    def at_the_floor(self) -> bool:
        """Whether the model with what was named leaves the noise."""
        return self.after <= NEAR_FLOOR

    def as_dict(self) -> dict[str, Any]:
        """Return it for a line of a file."""
        return {**asdict(self), "answer": self.answer, "out_of_sight": self.out_of_sight}

    @classmethod
    def of(cls, told: dict[str, Any]) -> "Outcome":
        """Return what :meth:`as_dict` told."""
        kept = {key: value for key, value in told.items() if key not in ("answer", "out_of_sight")}
        drawn = kept.pop("case")
        rest = {"hidden": tuple(drawn["hidden"]), "faults": Faults(**drawn.get("faults", {}))}
        case = Case(**{**drawn, **rest})
        sets = tuple(tuple(group) for group in kept.pop("sets"))
        return cls(case, sets=sets, named=tuple(kept.pop("named")), misfit=tuple(kept.pop("misfit")), **kept)


def run_case(case: Case, threads: int = 1) -> Outcome:
    """Make the recording of a case and diagnose it."""
    recording = make_recording(case)
    began = time.process_time()
    found = diagnose(recording, threads=threads)
    told = found.as_dict()
    spent = time.process_time() - began
    left = told["unexplained"]
    return Outcome(
        case,
        found.verdict,
        tuple(one.candidate.name for one in found.search.accepted),
        tuple(tuple(group) for group in found.indistinguishable),
        left["variable"] if left else "",
        told["error"]["before"],
        told["error"]["after"],
        (told["misfit"]["before"], told["misfit"]["after"]),
        spent,
        remaining_evidence(case),
    )
