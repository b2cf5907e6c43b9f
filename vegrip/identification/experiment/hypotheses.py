"""The contestants: models that a recording does not tell apart, each fitted to it.

Where a recording does not show an effect at all, its fitted amount is nothing and no experiment would tell it
from its absence; it then stands in at its declared size, and that is said.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vegrip.effects import effect
from vegrip.errors import UsageError
from vegrip.identification.diagnosis.candidate_fit import CandidateFit, evaluate_candidate, extend_problem
from vegrip.identification.diagnosis.catalogue import candidates
from vegrip.identification.diagnosis.regimes import held_out_groups
from vegrip.identification.diagnosis.score_tests import screen_candidates
from vegrip.identification.diagnosis.thresholds import MIN_GAIN_NATS
from vegrip.identification.fit.preprocess import LOADS_AT_SLIP, Measured
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.simulate import DEFAULT_NOISE
from vegrip.model import ContactModel

NO_EFFECT = "nothing"
"""Name of the model as it was given, without a further effect."""


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """What an experiment is to tell apart.

    Attributes:
        models: by the name of the effect that each has.
        assumed: names whose size is the declared one, because the recording does not show them.
        sensors: std of the noise of the channels that are measured, SI.
        rate: of the samples [Hz].

    """

    models: Mapping[str, ContactModel]
    assumed: tuple[str, ...]
    sensors: Mapping[str, float]
    rate: float

    @property
    def names(self) -> tuple[str, ...]:
        """The contestants."""
        return tuple(self.models)

    @property
    def has_tangential_load(self) -> bool:
        """Whether loads in the plane of the contact are measured."""
        return "tangential_force" in self.sensors


def hypotheses_of(
    start: Fit, names: Sequence[str], report: Callable[[str], None] = lambda _: None
) -> Hypotheses:
    """Fit each of ``names`` (effects, or "nothing") on top of ``start``.

    Raises:
        ModelError: there is no such effect.
        UsageError: fewer than two names, one that the model has, or one that the recording cannot show.

    """
    wanted = list(dict.fromkeys(names))
    if len(wanted) == 1 and wanted != [NO_EFFECT]:
        wanted.append(NO_EFFECT)
    if len(wanted) < 2:
        raise UsageError("an experiment distinguishes candidates; name two effects, or one to detect it")
    problem = start.problem
    for name in wanted:
        if name != NO_EFFECT and effect(name).name in {one.name for one in problem.model.effects}:
            raise UsageError(f"the model has {name} already; it is no candidate any more")
    possible, hidden = candidates(problem.model, problem.measured)
    groups = held_out_groups(problem)
    base = evaluate_candidate(problem, start.optimum, groups)
    models: dict[str, ContactModel] = {}
    assumed = []
    for name in wanted:
        report(f"fits {name}")
        if name == NO_EFFECT:
            models[name] = start.model
            continue
        if name in hidden and not _is_reachable(name, problem.measured):
            raise UsageError(f"no experiment with these sensors shows {name}: {hidden[name]}")
        found = None
        for candidate in possible:
            if candidate.name == name and (hints := screen_candidates(problem, start.optimum, [candidate])):
                found = extend_problem(base, hints[0], groups)
        if found is not None and found.evidence - base.evidence > MIN_GAIN_NATS:
            models[name] = _model(found)
        else:
            models[name] = start.model.with_effect(effect(name))
            assumed.append(name)
    return Hypotheses(models, tuple(assumed), sensors_of(problem.measured), rate_of(problem.measured))


def _model(found: CandidateFit) -> ContactModel:
    return fit_of(found.problem, found.optimum).model


def _is_reachable(name: str, measured: Measured) -> bool:
    """Whether another motion would show the effect with the channels that were recorded."""
    loaded = bool(LOADS_AT_SLIP & set(measured.recording.columns))
    return loaded and bool({"tangential_force", "torque_z"} & set(effect(name).channels))


def sensors_of(measured: Measured) -> dict[str, float]:
    """Return the noise of the channels that the recording has, as the fit took it."""
    noise, columns = measured.noise, set(measured.recording.columns)
    sensors = {"normal_force": noise.normal_force, "displacement": noise.displacement}
    if LOADS_AT_SLIP & columns:
        usual = {name: DEFAULT_NOISE[name] for name in ("tangential_force", "torque_z")}
        sensors |= {name: _known(getattr(noise, name), value) for name, value in usual.items()}
        sensors["slip_speed"] = DEFAULT_NOISE["slip_speed"]
    if "contact_radius" in columns and noise.contact_radius > 0.0:
        sensors["contact_radius"] = noise.contact_radius
    return sensors


def _known(value: float, otherwise: float) -> float:
    return value if value > 0.0 else otherwise


def rate_of(measured: Measured) -> float:
    """Return the usual rate of the samples [Hz]."""
    return float(1.0 / np.median(np.diff(measured.recording.t)))
