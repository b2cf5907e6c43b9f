"""What a recording does not feel has no derivatives, found without a run of the model."""

from dataclasses import replace

import numpy as np
import pytest

from vegrip.effects import BUILT_IN, effect
from vegrip.identification.fit.fitting import base_model
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.identification.fit.problem import DERIVATIVE_STEP, Problem
from vegrip.identification.fit.unfelt import unfelt
from vegrip.model import paper_model

FRICTION = {"tangential_force_x", "tangential_force_y", "torque_z", "slip", "slip_speed"}


def problem_of(recording, without: set[str]) -> Problem:
    columns = {name: one for name, one in recording.columns.items() if name not in without}
    part = replace(recording, columns=columns)
    return Problem(base_model(part), preprocess(part, noise_of(part)))


@pytest.mark.parametrize(
    ("without", "felt_not"),
    [
        (set(), set()),
        (FRICTION, {"mu", "k0"}),
        (FRICTION | {"contact_radius"}, {"mu", "k0"}),
    ],
)
def test_without_slips_friction_and_pressure_move_nothing(bench, without, felt_not) -> None:
    """And every other derivative is the difference of two runs."""
    problem = problem_of(bench(), without)
    u, k = problem.unknowns.start, problem.unknowns
    J, here = problem.jacobian(u), problem.residual(u)
    for j, name in enumerate(k.names):
        step = DERIVATIVE_STEP * k.std[j]
        moved = u + step * (np.arange(u.size) == j)
        apart = (problem.residual(moved) - here) / step
        assert J[:, j] == pytest.approx(apart, rel=1e-5, abs=1e-5 * max(np.abs(apart).max(), 1.0)), name
        assert not (J[:, j].any() and name in felt_not), name
        assert J[:, j].any() or name in felt_not, name


@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_what_is_said_to_be_unfelt_belongs_to_stages_that_read(name) -> None:
    """An effect on the force is felt in the force."""
    model = paper_model(5e-3)
    if name in {one.name for one in model.effects}:
        return
    model = model.with_effect(effect(name))
    none = unfelt(model, shows_slip=False, shows_radius=False)
    with_radius = unfelt(model, shows_slip=False, shows_radius=True)
    assert with_radius <= none
    assert not unfelt(model, shows_slip=True, shows_radius=False)
    if set(effect(name).channels) == {"normal_force"}:
        assert not none & {p.symbol for p in effect(name).parameters}
