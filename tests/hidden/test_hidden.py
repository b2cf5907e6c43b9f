"""Laws of a diagnosis, each on a short recording of the bench: what is hidden is named, nothing else."""

import itertools

import pytest

from vegrip.identification.diagnosis import diagnose

pytestmark = pytest.mark.slow


NEIGHBOURS = {
    "jkr_adhesion": ({"work": 1.0, "tip_radius": 0.01, "force": 1.8, "depth": 1e-3}, "adhesion"),
    "approach_tilt": ({"stiffness": 30.0}, "force_drift"),
    "force_drift": ({"rate": 1e-3}, "approach_tilt"),
    "second_contact": ({"force": 0.2, "reach": 5e-4, "gap": 9e-4}, "layer_over_core"),
    "layer_over_core": ({"thickness": 8e-3, "tip_radius": 0.01}, "second_contact"),
}
OFTEN = ("approach_tilt",)


@pytest.mark.parametrize(
    "name",
    [name if name in OFTEN else pytest.param(name, marks=pytest.mark.long) for name in NEIGHBOURS],
)
def test_of_two_that_resemble_each_other_the_hidden_one_is_said(hide, name) -> None:
    """Named, or one of a set, in which the other is not."""
    given, other = NEIGHBOURS[name]
    found = diagnose(hide(seed=3, **{name: given}))
    assert found.verdict in ("named", "ambiguous")
    said = {*found.named, *itertools.chain(*found.indistinguishable)}
    assert name in said
    assert other not in said


@pytest.mark.long
def test_two_hidden_both_named(hide) -> None:
    found = diagnose(hide(seed=5, sensor_lag={"time": 5e-3}, load_dependent_friction={"exponent": 0.2}))
    assert set(found.named) == {"sensor_lag", "load_dependent_friction"}
    assert found.error["after"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "given", "variable"),
    [
        ("cogging", {"force": 0.04, "period": 5e-4}, "displacement"),
        ("day_and_night", {"share": 0.04, "period": 150.0}, "time"),
    ],
)
def test_what_no_catalogue_has_is_unexplained_and_its_variable_told(hide, name, given, variable) -> None:
    found = diagnose(hide(seed=6, **{name: given}), most=1)
    assert found.verdict == "unexplained"
    assert found.named == []
    assert found.unexplained is not None
    assert found.unexplained.variable == variable
