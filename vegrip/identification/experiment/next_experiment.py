"""The experiment after an ambiguous diagnosis, whose models are at hand already."""

from typing import Any

from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.experiment.design import design
from vegrip.identification.experiment.hypotheses import Hypotheses, rate_of, sensors_of
from vegrip.identification.experiment.limits import RigLimits, complete_limits, limits_of
from vegrip.identification.fit.result import fit_of


def hypotheses_after(found: Diagnosis) -> Hypotheses | None:
    """Return the first set that ``found`` could not tell apart; None where there is none."""
    if not found.indistinguishable:
        return None
    names = set(found.indistinguishable[0])
    for step in found.search.steps:
        tried = {one.candidate.name: one for one in step.tried if one.candidate.name in names}
        if tried.keys() == names:
            models = {n: fit_of(one.fitted.problem, one.fitted.optimum).model for n, one in tried.items()}
            measured = found.start.problem.measured
            return Hypotheses(models, (), sensors_of(measured), rate_of(measured))
    return None


def next_experiment(found: Diagnosis) -> dict[str, Any] | None:
    """Return what a diagnosis says of the next experiment: a quick look at the menu, within what was done."""
    contest = hypotheses_after(found)
    if contest is None:
        return None
    limits = complete_limits(RigLimits(), limits_of(found.start.problem.measured.recording))
    made = design(contest, limits, is_thorough=False).as_dict()
    effects = {e.name: e for model in contest.models.values() for e in model.effects}
    told = {name: effects[name].experiment for name in contest.names if effects[name].experiment}
    return {**made, "suggestions": told}
