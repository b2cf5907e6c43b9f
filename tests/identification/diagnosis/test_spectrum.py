"""Relaxation at three times, which the bench sums over its history as a Prony series."""

from dataclasses import replace

import numpy as np
import pytest

from tests.identification.bench import CLEAR, SENSORS, TIP, recorded
from vegrip.effects import BUILT_IN
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.error_ladder import add_effect
from vegrip.identification.diagnosis.score_tests import candidates
from vegrip.identification.experiment.hypotheses import hypotheses_of
from vegrip.identification.fit import Fit, fit
from vegrip.model import BASE, predict
from vegrip.virtual.bench.protocol import hold, sine, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.history import prony

pytestmark = pytest.mark.slow

THREE_TIMES = replace(TIP, amplitudes=(0.1, 0.3, 0.1), rates=(0.1, 3.1, 40.0))
HOLDS = [
    (CLEAR, *episode[1:], CLEAR)
    for episode in (hold(1e-3, 20.0), hold(6e-4, 5.0), hold(1.5e-3, 5.0), triangles(1.3e-3, 8e-3, 2))
]
SINES = [sine(1e-3, 3e-4, frequency, 6) for frequency in (1.0, 3.0, 10.0)]
QUIET = replace(SENSORS, normal_force=0.0, displacement=0.0, force_bias=0.0, displacement_bias=0.0)


@pytest.fixture(scope="module")
def start() -> Fit:
    return fit(recorded("relaxing", 0, {}, HOLDS, THREE_TIMES))


def errors(name: str, start: Fit) -> tuple[float, float]:
    """Return the largest relative error of the force of a step, 2 ms .. 20 s, and that of sines [N]."""
    model = add_effect(name, start)[0].model
    t = np.concatenate([[0.0, 1e-6], np.geomspace(2e-3, 20.0, 50)])
    step = model.simulate(t, np.where(t > 0.0, 1e-3, 0.0)).normal_force[2:]
    modulus = TIP.reference_force * prony(THREE_TIMES.amplitudes, THREE_TIMES.rates)(t[2:])
    sines = run_trial(THREE_TIMES, SINES, QUIET, step=2.5e-3, rings=8, spokes=16, truth=False).columns
    off = predict(model, sines)["normal_force"] - sines["normal_force"]
    return float(np.max(np.abs(step / modulus - 1.0))), float(np.sqrt(np.mean(off**2)))


def test_a_spectrum_added_by_hand_has_the_modulus_and_predicts_sines_that_no_fit_saw(start) -> None:
    modulus, sines = errors("relaxation_spectrum", start)
    modulus_of_two, sines_of_two = errors("second_relaxation", start)
    assert modulus < 0.02
    assert modulus < 0.5 * modulus_of_two
    assert sines < 0.5 * sines_of_two


def test_a_diagnosis_looks_for_every_effect_but_a_spectrum(start) -> None:
    possible, out_of_sight = candidates(start.problem.model, start.problem.measured)
    missing = {*BUILT_IN} - {*BASE, *out_of_sight, *(one.name for one in possible)}
    assert missing == {"relaxation_spectrum"}
    search = diagnose(start.problem.measured.recording).search
    screened = {hint.candidate.name for step in search.steps for hint in step.hints}
    assert "power_law_relaxation" in screened
    assert "relaxation_spectrum" not in screened


def test_a_model_that_has_a_spectrum_lacks_nothing(start) -> None:
    model = add_effect("relaxation_spectrum", start)[0].model
    assert diagnose(start.problem.measured.recording, model).verdict == "adequate"


def test_an_experiment_tells_a_spectrum_that_is_asked_for(start) -> None:
    assert hypotheses_of(start, ["relaxation_spectrum", "second_relaxation"]).assumed == ()
