"""Relaxation at three times, which the bench sums over its history as a Prony series."""

from dataclasses import replace

import numpy as np
import pytest

from tests.identification.bench import CLEAR, SENSORS, TIP, recorded
from vegrip.identification.diagnosis import Diagnosis, diagnose
from vegrip.identification.diagnosis.error_ladder import add_effect
from vegrip.identification.experiment.hypotheses import hypotheses_of
from vegrip.identification.fit import Fit, fit
from vegrip.model import predict
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
LONG = [
    (CLEAR, *episode[1:], CLEAR)
    for episode in (
        hold(1e-3, 30.0),
        hold(6e-4, 15.0),
        hold(1.5e-3, 5.0),
        sine(1e-3, 3e-4, 8.0, 16),
        triangles(1.3e-3, 8e-3, 1),
    )
]
QUIET = replace(SENSORS, normal_force=0.0, displacement=0.0, force_bias=0.0, displacement_bias=0.0)


@pytest.fixture(scope="module")
def start() -> Fit:
    return fit(recorded("relaxing", 0, {}, HOLDS, THREE_TIMES))


def errors(name: str, start: Fit) -> tuple[float, float]:
    """Return the largest relative error of the force, two rows to 20 s into a step, and that of sines [N]."""
    model = add_effect(name, start)[0].model
    t = np.concatenate([[0.0, 1e-6], np.geomspace(0.01, 20.0, 50)])
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


def diagnosed(hidden: dict, tip, protocol) -> Diagnosis:
    return diagnose(recorded("relaxing", 0, hidden, protocol, tip))


def test_a_spectrum_has_the_amplitudes_that_are_there() -> None:
    """Those a decade from others; 40 1/s lies between two of the spectrum's, and 3.1 1/s is the base's."""
    found = add_effect("relaxation_spectrum", fit(recorded("relaxing", 0, {}, LONG, THREE_TIMES)))[0].model
    value = {symbol: value.value for symbol, value in found.values.items()}
    assert value["nu_s"] == pytest.approx(0.01, rel=0.05)
    assert [value[f"c_s{i}"] for i in (1, 2, 3)] == pytest.approx([0.0, 0.1, 0.0], abs=0.01)


@pytest.mark.long
def test_three_times_of_which_one_law_leaves_more_than_noise_are_named_a_spectrum() -> None:
    found = diagnosed({}, replace(TIP, amplitudes=(0.05, 0.3, 0.05), rates=(0.3, 3.1, 30.0)), LONG)
    assert (found.verdict, found.named) == ("named", ["relaxation_spectrum"])


@pytest.mark.long
def test_a_spectrum_and_the_two_laws_that_imitate_it_stand_beside_each_other() -> None:
    found = diagnosed({}, THREE_TIMES, [*HOLDS, sine(1e-3, 3e-4, 8.0, 16)])
    assert found.verdict == "ambiguous"
    assert found.named == []
    assert found.indistinguishable == [
        ["power_law_relaxation", "relaxation_spectrum"],
        ["second_relaxation", "relaxation_spectrum"],
    ]


@pytest.mark.long
def test_a_power_law_that_leaves_noise_is_no_spectrum() -> None:
    found = diagnosed({"power_law_relaxation": {"amplitude": 0.3}}, TIP, LONG)
    assert (found.verdict, found.named) == ("named", ["power_law_relaxation"])
    assert "relaxation_spectrum" not in {hint.candidate.name for s in found.search.steps for hint in s.hints}


def test_a_model_that_has_a_spectrum_lacks_nothing(start) -> None:
    model = add_effect("relaxation_spectrum", start)[0].model
    assert diagnose(start.problem.measured.recording, model).verdict == "adequate"


def test_an_experiment_tells_a_spectrum_that_is_asked_for(start) -> None:
    assert hypotheses_of(start, ["relaxation_spectrum", "second_relaxation"]).assumed == ()
