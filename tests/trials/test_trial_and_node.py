"""A trial is what the node on a bus does: the same hand and control, met by messages."""

from dataclasses import replace

import numpy as np
import pytest

from validation.controllers.comparison import Trial, run_course
from validation.controllers.node_loop import NodeLoop
from vegrip.trials.candidates import KNOBS, make_node, parameters
from vegrip.trials.closed_loop import Course, Loop, Scenario, grip_of, run_grip
from vegrip.virtual import VirtualHand

TRIALS = [
    Trial("vegrip", 3, 4.0, 0.15, "pinch"),
    Trial("elastic", 31, 3.0, 0.6, "pinch"),
    Trial("cone", 24, 2.0, 2.0, "pinch"),
    Trial("learning", 5, 2.0, 0.15, "hand"),
    Trial("learning", 3, 3.0, 0.1, "pinch"),
    Trial("constant", 3, 2.5, 0.9, "pinch"),  # far too light: it loses the object
]


def by_messages(trial: Trial) -> Course:
    """Run ``trial`` with the node, by messages."""
    scenario = Scenario(trial.seed, trial.duration, trial.grasp)
    settings = parameters(trial.name, trial.knob, scenario.settings.tip.friction)
    hand = scenario.hand()
    return NodeLoop(hand, make_node(settings, hand.fingers)).run(trial.duration)


@pytest.mark.parametrize("trial", TRIALS, ids=lambda trial: f"{trial.name}-{trial.grasp}")
def test_a_trial_has_the_slips_forces_and_margins_of_the_node_on_a_bus(trial: Trial) -> None:
    node, course = by_messages(trial), run_course(trial)
    assert (course.slips, course.dropped) == (node.slips, node.dropped)
    assert course.time == node.time
    assert np.allclose(course.force, node.force, atol=1e-9)
    assert np.allclose(course.margin, node.margin, atol=1e-9)
    if node.friction:
        time, mu, std = np.array(node.friction).T  # as the first finger reports it
        looks = np.flatnonzero(np.isfinite(np.array(course.stated)[:, 0, 0]))
        rows = looks[np.searchsorted(np.array(course.time)[looks], time - 1e-6).clip(max=len(looks) - 1)]
        ln_mu, spread = np.array(course.stated)[rows, 0].T
        assert np.median(np.abs(np.exp(ln_mu) / mu - 1.0)) < 0.02
        assert 0.98 < np.median(std / mu / spread) < 1.1  # of mu, which has a tail, over that of ln mu


def test_a_grip_that_is_far_too_light_loses_the_object() -> None:
    assert run_course(TRIALS[-1]).dropped


@pytest.mark.long
def test_every_controller_of_the_comparison_runs() -> None:
    rest = KNOBS["pinch"].keys() - {trial.name for trial in TRIALS} - {"known"}  # which a test below runs
    assert rest == {"ellipse"}
    run = run_course(Trial("ellipse", 5, 1.2, KNOBS["pinch"]["ellipse"], "pinch"))
    assert len(run.time) == 121
    assert not run.dropped


def test_samples_that_get_lost_are_silence_and_the_grip_holds() -> None:
    scenario = Scenario(3, 2.0, "pinch")
    sensor = replace(scenario.settings.sensor, dropout=0.3)
    hand = VirtualHand(replace(scenario.settings, sensor=sensor), 3, scenario.events)
    assert not run_grip(hand, parameters("vegrip", 0.15), 2.0).dropped


def test_values_that_are_spoiled_are_what_the_controller_feels() -> None:
    def deaf(values: np.ndarray) -> None:
        values[:, 0] = np.nan

    scenario, settings = Scenario(3, 1.0, "pinch"), parameters("vegrip", 0.15)
    loops = [Loop(scenario.hand(), grip_of(settings, ("thumb", "index")), spoil) for spoil in (None, deaf)]
    for loop in loops:
        loop.run(1.0)
    sound, spoiled = (loop.grip.fingers["index"].numbers.felt()[0] for loop in loops)
    assert np.isfinite(sound)
    assert np.isnan(spoiled)


def test_who_knows_the_truth_needs_less_than_who_estimates_it() -> None:
    known, estimated = (run_course(Trial(name, 5, 4.0, 0.1, "pinch")) for name in ("known", "vegrip"))
    assert known.slips == 0
    assert np.mean(known.force[200:]) < 0.8 * np.mean(estimated.force[200:])
