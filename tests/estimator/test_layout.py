"""The constants of the kernels are written from the layout, and all of them are used by name."""

import ast
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.estimator import ContactEstimator, SensorNoise, kernels
from vegrip.estimator.compiled import node_text_of
from vegrip.estimator.layout import layout_of, state_names
from vegrip.messages import FingertipState
from vegrip.model import ContactModel, paper_model

KERNELS = sorted(path for path in Path(kernels.__file__).parent.glob("*.py") if path.stem != "__init__")


def test_every_model_has_the_same_names() -> None:
    base = paper_model(8e-3)
    richer = base.with_effect(effect("mullins_softening")).with_effect(effect("second_relaxation"))
    assert layout_of(base).names().keys() == layout_of(richer).names().keys()


@pytest.mark.parametrize(
    ("name", "own"),
    [("mullins_softening", {"x_max"}), ("adhesion", {"sticking"}), ("second_relaxation", set())],
)
def test_measurements_correct_all_of_the_state_but_what_remembers_an_extreme(
    name: str, own: set[str]
) -> None:
    model = paper_model(8e-3).with_effect(effect(name))
    layout = layout_of(model)
    kept: Any = layout.names()["KEPT"]
    names = state_names(model, layout)
    assert {state for state, is_kept in zip(names, kept, strict=True) if is_kept} == own | {"largest_force"}


def test_every_constant_is_used_by_a_kernel() -> None:
    model = paper_model(8e-3)
    text, names = node_text_of(model, layout_of(model)), layout_of(model).names()
    assert [name for name in names if len(re.findall(rf"\b{name}\b", text)) < 2] == []


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.stem)
def test_no_kernel_adds_a_bare_number_to_a_place(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Subscript) and ast.unparse(node.value).startswith("m."):
            numbers = [one.value for one in ast.walk(node.slice) if isinstance(one, ast.Constant)]
            assert numbers in ([], [0]), f"line {node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.stem)
def test_regimes_and_channels_are_compared_by_name(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Compare):
            about = ast.unparse(node.left)
            if "regime" in about.lower() or about == "channel":
                assert not any(isinstance(one, ast.Constant) for one in node.comparators), ast.unparse(node)


def test_the_state_is_told_by_name_with_what_the_covariance_says(
    estimator: ContactEstimator, model: ContactModel, press: object, run: object
) -> None:
    assert not any(one.valid for one in estimator.state.values())
    e = run(estimator, press(model, [0.0, 0.3, 0.8, 1.5], [-1e-4, -1e-4, 9e-4, 9e-4]))  # type: ignore[operator]
    state, names = estimator.state, estimator.state_names
    assert tuple(state) == names
    assert names[:2] == ("indentation", "speed")
    assert names[-2:] == ("displacement_offset", "force_bias")
    assert len(names) == len(set(names)) == len(estimator.covariance)
    assert state["indentation"].value == e.indentation.value
    assert all(one.valid for one in state.values())
    spreads = [one.std for one in state.values()]
    np.testing.assert_allclose(np.square(spreads), np.diag(estimator.covariance), rtol=1e-12)
    assert np.exp(state["ln K"].value) == pytest.approx(estimator.value("K").value)
    assert state["ln K"].std == pytest.approx(estimator.value("K").std)


@pytest.mark.other_model
def test_states_of_added_effects_have_their_own_names() -> None:
    estimator = ContactEstimator(paper_model(8e-3).with_effect(effect("mullins_softening")), SensorNoise())
    assert set(estimator.model.plan.states) <= set(estimator.state_names)


EFFECTS_WITH_MEMORY = (
    "mullins_softening",
    "second_relaxation",
    "adhesion",
    "friction_ageing",
    "poroelastic_drainage",
)


@pytest.mark.parametrize(
    "name", ["", *(pytest.param(name, marks=pytest.mark.other_model) for name in EFFECTS_WITH_MEMORY)]
)
def test_a_sample_depends_on_nothing_but_what_lasts(name: str) -> None:
    """The memory behind ``lasting`` is spoilt before each of some samples with faults, gaps and slips."""
    model = paper_model(8e-3).with_effect(effect(name)) if name else paper_model(8e-3)
    estimator = ContactEstimator(model, SensorNoise())
    rng, lasting = np.random.default_rng(3), estimator.layout.lasting
    t = np.cumsum(rng.choice([2e-3, 2e-3, 2e-3, 0.3], 300))
    depth = np.interp(t, [0.1, t[150], t[160], t[-1]], [-2e-4, 1e-3, 2e-4, 8e-4])
    force = model.simulate(t, depth).normal_force + 0.02 * rng.standard_normal(t.size)
    force[rng.random(t.size) < 0.1], depth[rng.random(t.size) < 0.1] = np.nan, np.nan
    force[rng.random(t.size) < 0.02] += 5.0
    numbers = np.column_stack([force, depth, 0.2 * rng.random(t.size), rng.random(t.size) < 0.05])
    samples = [
        FingertipState(int(1e9 * now), "tip", i, n, f, 0.0, 1e-4, d, 25.0, slip)
        for i, (now, (n, d, f, slip)) in enumerate(zip(t.tolist(), numbers.tolist(), strict=True))
    ]
    known = []
    for is_spoilt in (False, True):
        estimator.reset()
        for sample in samples:
            if is_spoilt:
                estimator.numbers[lasting:] = rng.uniform(-1e3, 1e3, estimator.layout.size - lasting)
            estimator.assimilate(sample)
        known.append((estimator.memory[:lasting].tobytes(), repr(estimator.slip_margin())))
    assert known[0] == known[1]
