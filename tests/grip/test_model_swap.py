"""A new model is taken over in a running node without a gap, and a bad one is not taken at all."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from vegrip.nodes.grasp_force import build

from vegrip.errors import ModelError
from vegrip.grip import compile_worker
from vegrip.grip import model_swap as module
from vegrip.grip.parameters import GraspParameters
from vegrip.messages import FingertipState, ForceCommand, ModelHealth
from vegrip.model import paper_model, write_model
from vegrip.runtime import NodeContext

PERIOD = 2_000_000  # [ns]


@pytest.fixture
def node(monkeypatch):
    """An active node; its threads are joined, so that tests know when a model is ready."""
    threads = []
    begin = module.ModelSwap.begin

    def noted(self, *arguments):
        threads.append(begin(self, *arguments))
        return threads[-1]

    monkeypatch.setattr(module.ModelSwap, "begin", noted)
    made = build({}, NodeContext("grasp_force", "", ("index",), 0.002))
    made.configure()
    made.activate()
    made.threads = threads
    return made


def states(count, model, seed=1):
    rng = np.random.default_rng(seed)
    t = np.arange(count) * PERIOD * 1e-9
    depth = np.interp(t, [0.1, 0.4, 0.8, 1.0, 1.3], [-1e-4, 1e-3, 1e-3, 5e-4, 1e-3])
    force = model.simulate(t, depth).normal_force + 0.01 * rng.standard_normal(count)
    return [
        FingertipState(i * PERIOD, "index", i, force[i], 0.3 * force[i], 0.0, 0.0, depth[i], slip=0.0)
        for i in range(count)
    ]


def fed(node, given):
    """Return all answers; each state must get its command."""
    answers = []
    for state in given:
        got = [*node.on_message(state, state.stamp), *node.on_tick(state.stamp)]
        assert any(isinstance(message, ForceCommand) for message in got)
        answers += got
    return answers


def with_tip(node, **changes):
    parameters = node.parameters
    node.parameters = dataclasses.replace(parameters, tip=dataclasses.replace(parameters.tip, **changes))


def test_the_successor_knows_what_the_predecessor_felt_and_no_command_is_missing(node, tmp_path):
    truth = paper_model(9e-3).with_value("K", 3.0 * paper_model(9e-3).values["K"].value)
    given = states(1500, truth)
    fed(node, given[:900])
    old = node.fingers["index"].estimator
    write_model(truth, tmp_path / "better.toml")
    with_tip(node, model=str(tmp_path / "better.toml"))
    fed(node, given[900:905])
    for thread in node.threads:
        thread.join()
    before, after = fed(node, given[905:906]), fed(node, given[906:])
    new = node.fingers["index"].estimator
    assert new is not old
    assert new.model.values["K"].value == pytest.approx(truth.values["K"].value)
    assert new.in_contact
    assert new.contact_estimate().stamp == given[-1].stamp
    commands = [m.normal_force for m in (*before, *after) if isinstance(m, ForceCommand)]
    steps = np.abs(np.diff(commands))
    assert steps.max() <= 80.0 * 0.002 + 1e-9, "no faster than the limit of the rate"
    health = [m for m in after if isinstance(m, ModelHealth)]
    assert health
    assert math.isfinite(health[-1].nis)


@pytest.mark.parametrize("name", ["missing.toml", "broken.toml"])
def test_a_model_that_cannot_be_used_is_counted_and_the_old_one_stays(node, tmp_path, name, caplog):
    (tmp_path / "broken.toml").write_text("[fingertip]\ntip_radius = -1.0\n")
    given = states(600, paper_model(9e-3))
    fed(node, given[:500])
    old = node.fingers["index"].estimator
    with_tip(node, model=str(tmp_path / name))
    for thread in node.threads:
        thread.join()
    fed(node, given[500:])
    assert node.fingers["index"].estimator is old
    assert node.rejected["model refused"] == 1
    assert "the new model is not used" in caplog.text


def test_a_change_of_other_parameters_builds_nothing(node):
    node.parameters = dataclasses.replace(node.parameters, report_period=0.1)
    assert node.threads == []
    assert isinstance(node.parameters, GraspParameters)


def test_of_two_requests_the_later_counts(node):
    given = states(300, paper_model(9e-3))
    fed(node, given[:200])
    with_tip(node, radius=8e-3)
    with_tip(node, radius=7e-3)
    for thread in node.threads:
        thread.join()
    fed(node, given[200:])
    assert node.fingers["index"].estimator.model.tip_radius == 7e-3


@pytest.mark.parametrize(
    ("said", "reason"), [("warning\nno compiler\n", "no compiler"), ("\n", "it does not")]
)
def test_a_model_that_does_not_compile_is_refused_with_the_last_that_was_said(said, reason, monkeypatch):
    asked = []

    def run(worker, arguments, *, idle, given):
        asked.append((worker, arguments, idle, given))
        return SimpleNamespace(returncode=1, stderr=said)

    monkeypatch.setattr(module, "run_behind", run)
    with pytest.raises(ModelError, match=f"^{reason}"):
        module.compile_in_subprocess(paper_model(9e-3))
    (one,) = asked
    assert one[:3] == ("vegrip.grip.compile_worker", ["/dev/stdin"], False)  # it is waited for


def test_the_worker_compiles_for_a_finger_and_says_in_a_sentence_why_it_does_not(
    tmp_path, capsys, monkeypatch
):
    asked = []
    monkeypatch.setattr(compile_worker, "GripController", lambda *given: asked.append(given))
    write_model(paper_model(9e-3), tmp_path / "tip.toml")
    assert compile_worker.main(tmp_path / "tip.toml") == 0
    assert [fingers for fingers, _ in asked] == [("finger",)]
    assert compile_worker.main(tmp_path / "none.toml") == ModelError.exit_code != 0
    assert capsys.readouterr().err.count("\n") == 1
