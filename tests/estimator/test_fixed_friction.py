"""A friction coefficient that is known is used and not learned, whatever it is called."""

import dataclasses
import math

import pytest

from vegrip.effects.contract import Effect, hook
from vegrip.errors import ModelError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB, FrictionPrior, prior_belief
from vegrip.estimator.layout import friction_symbol, layout_of
from vegrip.grip.parameters import TipParameters, _model
from vegrip.model import ContactModel, paper_model, write_model
from vegrip.parameters import Parameter, declared

R = 8e-3


def grip(slippery: float) -> float:
    """Return the friction coefficient."""
    return slippery


def always_half() -> float:
    """Return the friction coefficient."""
    return 0.5


SLIPPERY = Effect(
    name="slippery",
    summary="Coulomb's law by another name",
    cites=(),
    parameters=(Parameter("slippery", "1", 0.6, 0.3, 0.01, 20.0, "friction", transform="log", learn=True),),
    hooks=(hook(grip, stage="friction"),),
)


def with_friction(effect: Effect) -> ContactModel:
    model = paper_model(R)
    effects = tuple(effect if e.name == "coulomb_friction" else e for e in model.effects)
    values = {symbol: value for symbol, value in model.values.items() if symbol != "mu"}
    values |= {p.symbol: declared(p) for p in effect.parameters}
    return dataclasses.replace(model, effects=effects, values=values)


def test_a_friction_that_is_not_to_be_learned_stays_as_it_is_told(press, run) -> None:
    model = paper_model(R)
    known = model.with_value("mu", 0.5, std=0.1, learn=False)
    estimator = ContactEstimator(known, SensorNoise(), EstimatorSettings(friction=COULOMB))
    slides = press(model, [0.0, 0.3, 0.8, 3.0], [-1e-4, -1e-4, 9e-4, 9e-4], share=0.5, slip_after=1.5)
    estimate = run(estimator, slides)
    mu = estimator.value("mu")
    assert mu.value == pytest.approx(0.5, rel=1e-12)
    assert mu.std == pytest.approx(0.1, rel=1e-12)
    assert estimate.limit_force.value == pytest.approx(0.5 * estimate.normal_force.value, rel=1e-9)
    margin = estimator.slip_margin()
    assert margin.margin.valid
    assert math.isfinite(margin.lower_bound)


@pytest.mark.parametrize("exponent_std", [0.0, 0.12])
def test_a_friction_without_a_spread_is_believed_at_every_load(exponent_std: float) -> None:
    known = paper_model(R).with_value("mu", 0.5, std=0.0, learn=False)
    prior = FrictionPrior(load_exponent=0.15, load_exponent_std=exponent_std, tangential_gain_std=0.1)
    assert prior_belief(known, "mu", prior) == (math.log(0.5), 0.0, 0.0, 0.0)


def test_friction_of_a_fitted_model_is_apparent_so_the_gain_of_the_sensors_leaves_it_as_it_is() -> None:
    """It was fitted to what these channels show; what is stated of a material is the true one."""
    fitted = paper_model(R).with_value("mu", 0.5, std=0.1)
    prior = FrictionPrior(load_exponent=0.15, load_exponent_std=0.12, tangential_gain=0.9)
    assert prior_belief(fitted, "mu", prior) == pytest.approx((math.log(0.5), 0.1**2, 0.15, 0.12**2))
    stated = dataclasses.replace(prior, coefficient=0.5, coefficient_std=0.1)
    believed = prior_belief(fitted, "mu", stated)
    assert believed[:2] == pytest.approx((math.log(0.45), 0.1**2 + 0.1**2))


def test_of_no_material_friction_is_believed_as_published_of_soft_tips_by_sensors_that_read_low() -> None:
    believed = prior_belief(paper_model(R), "mu", FrictionPrior())
    expected = (math.log(0.5 * 0.92), 0.35**2 + 0.1**2, 0.15, 0.12**2)
    assert believed == pytest.approx(expected)


@pytest.mark.other_model
def test_the_friction_coefficient_may_have_another_name(monkeypatch) -> None:
    monkeypatch.setenv("VEGRIP_KERNEL", "python")  # nothing is computed
    model = with_friction(SLIPPERY)
    assert friction_symbol(model) == "slippery"
    assert list(model.parameters)[layout_of(model).mu] == "slippery"
    estimator = ContactEstimator(model, SensorNoise(), EstimatorSettings(friction=COULOMB))
    assert estimator.value("slippery").value == pytest.approx(0.6)


def test_the_tip_of_a_node_has_the_friction_it_is_given(tmp_path) -> None:
    write_model(paper_model(R).with_value("mu", 0.9, learn=False), tmp_path / "tip.toml")
    told = _model(TipParameters(model=str(tmp_path / "tip.toml"), friction=0.3)).values["mu"]
    assert (told.value, told.learn) == (0.3, False)


def test_friction_without_a_parameter_is_one_sentence() -> None:
    effect = dataclasses.replace(
        SLIPPERY, name="half", parameters=(), hooks=(hook(always_half, stage="friction"),)
    )
    with pytest.raises(ModelError, match="the effect half defines friction without a parameter"):
        layout_of(with_friction(effect))
