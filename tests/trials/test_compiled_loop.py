"""The compiled trial is the uncompiled loop: the same hand, estimator and control, checked against it."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from validation.controllers.comparison import Trial, run_course
from vegrip.trials import compiled_loop
from vegrip.trials.candidates import KNOBS, parameters
from vegrip.trials.compiled_loop import CompiledRun, run_compiled
from vegrip.trials.layout import TrialLayout
from vegrip.trials.scenario import Scenario
from vegrip.virtual import VirtualHand

TRIALS = [
    Trial("vegrip", 3, 4.0, 0.15, "pinch"),
    Trial("elastic", 31, 4.5, 0.6, "pinch"),
    Trial("cone", 24, 3.0, 2.0, "pinch"),
    Trial("vegrip", 0, 2.2, 0.0, "hand"),
    Trial("learning", 5, 2.0, 0.15, "hand"),
    Trial("learning", 3, 3.0, 0.1, "pinch"),
]


def compiled(trial: Trial) -> CompiledRun:
    """Run ``trial`` as one compiled call."""
    scenario = Scenario(trial.seed, trial.duration, trial.grasp)
    settings = parameters(trial.name, trial.knob, scenario.settings.tip.friction)
    return run_compiled(scenario.settings, trial.seed, scenario.events, settings, trial.duration)


@pytest.mark.parametrize("trial", TRIALS, ids=lambda trial: f"{trial.name}-{trial.grasp}")
def test_the_compiled_trial_has_the_slips_forces_and_margins_of_the_uncompiled_one(trial: Trial) -> None:
    slow, fast = run_course(trial), compiled(trial)
    assert (fast.slips, fast.dropped) == (slow.slips, slow.dropped)
    assert np.allclose(fast.time, slow.time)
    _, margin, force = slow.since(1.0)
    late = fast.time >= 1.0
    assert np.max(np.abs(fast.truth["force"][late] - force)) < 0.005
    assert np.max(np.abs(fast.truth["margin"][late] - margin)) < 0.01
    time, mu, std = np.array(slow.friction).T  # as the first finger reports it
    rows = np.searchsorted(fast.time, time - 0.003)
    assert np.median(np.abs(np.exp(fast.truth["ln_mu_stated"][rows, 0]) / mu - 1.0)) < 0.02
    wider = std / mu / fast.truth["ln_mu_std"][rows, 0]  # of mu, which has a tail, over that of ln mu
    assert 0.98 < np.median(wider) < 1.1


def test_a_slip_is_counted_in_the_compiled_trial_as_in_the_other() -> None:
    """A grip that is far too light loses the object in both at the same time."""
    trial = Trial("constant", 3, 2.5, 0.9, "pinch")
    slow, fast = run_course(trial), compiled(trial)
    assert slow.slips > 0
    assert (fast.slips, fast.dropped) == (slow.slips, slow.dropped)
    assert fast.time[-1] == pytest.approx(slow.time[-1], abs=0.011)


def test_every_controller_of_the_comparison_runs_compiled() -> None:
    for name, knob in KNOBS["pinch"].items():
        run = compiled(Trial(name, 5, 1.2, knob, "pinch"))
        assert len(run.time) == 121
        assert not run.dropped


def test_the_declared_names_are_those_that_the_layout_gives() -> None:
    lines = TrialLayout(2, 3, 4, 2).constants().splitlines()
    given = {line.split(" = ")[0] for line in lines}
    stub = Path(compiled_loop.__file__).with_name("kernels") / "generated.py"
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    declared = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}  # type: ignore[union-attr]
    assert declared == given


def test_a_late_and_coarse_slip_channel_is_late_and_coarse() -> None:
    """Both loops share the errors of the sensor; the flag comes by the delay later, and not below it."""
    scenario = Scenario(3, 2.5, "pinch")

    def first_flag(threshold: float, delay: float) -> float:
        sensor = replace(scenario.settings.sensor, slip_threshold=threshold, slip_delay=delay)
        hand = VirtualHand(replace(scenario.settings, sensor=sensor), 3, scenario.events)
        while hand.time < 2.5:
            states = hand.step(0.002, {"thumb": 0.9, "index": 0.9})
            if any(state.slip > 0.5 for state in states):
                return hand.time
        return np.inf

    at_once = first_flag(0.0, 0.0)
    assert first_flag(0.0, 0.02) == pytest.approx(at_once + 0.02, abs=1e-6)
    assert at_once < first_flag(5e-3, 0.0) < np.inf
    assert first_flag(1.0, 0.0) == np.inf
