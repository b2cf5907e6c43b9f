"""What the estimator says of contacts whose truth is known."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from vegrip.contact.limit_surface import reference
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.compiled import module_for
from vegrip.estimator.estimator import LOST, quantile
from vegrip.estimator.friction_prior import COULOMB
from vegrip.estimator.health import HealthHysteresis
from vegrip.messages import BEYOND_FIT, NAN, UNKNOWN, Channel, ContactEstimate, FingertipState
from vegrip.model import ContactModel, Shown, paper_model

Record = Callable[..., list[FingertipState]]
Run = Callable[[ContactEstimator, list[FingertipState]], ContactEstimate]
KNOTS, DEPTHS = [0.0, 0.3, 0.8, 3.0], [-1e-4, -1e-4, 9e-4, 9e-4]


def other(model: ContactModel) -> ContactModel:
    """A fingertip that is not the prior's mean."""
    K = model.values["K"].value
    return model.with_value("K", 1.3 * K).with_value("c1", 0.22).with_value("mu", 0.8)


def without(states: list[FingertipState], *channels: str) -> list[FingertipState]:
    return [dataclasses.replace(s, **dict.fromkeys(channels, NAN)) for s in states]


def test_a_hold_is_estimated_within_its_stated_spread(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    true = other(model)
    estimate = run(estimator, press(true, KNOTS, DEPTHS, share=0.4))
    t = np.arange(1500) / 500.0
    contact = true.simulate(t, np.interp(t, KNOTS, DEPTHS))
    for found, wanted in (
        (estimate.normal_force, contact.normal_force[-1]),
        (estimate.contact_radius, contact.contact_radius[-1]),
        (estimate.pressure_exponent, contact.pressure_exponent[-1]),
        (estimate.indentation, 9e-4),
    ):
        assert found.valid
        assert abs(found.value - wanted) < 3.0 * found.std
    assert estimate.in_contact
    assert estimate.normal_force.std < 0.02
    assert estimate.channels == (
        Channel.FORCE | Channel.POSITION | Channel.TANGENTIAL | Channel.TORQUE | Channel.SLIP
    )


@pytest.mark.parametrize(
    ("missing", "channel"), [("displacement", Channel.FORCE), ("normal_force", Channel.POSITION)]
)
def test_one_channel_suffices_and_costs_certainty(
    estimator: ContactEstimator,
    model: ContactModel,
    press: Record,
    run: Run,
    missing: str,
    channel: Channel,
) -> None:
    true = other(model)
    states = press(true, KNOTS, DEPTHS, share=0.4)
    both = run(estimator, states)
    estimator.reset()
    one = run(estimator, without(states, missing))
    assert one.channels & (Channel.FORCE | Channel.POSITION) == channel
    assert one.limit_radius.std > both.limit_radius.std
    assert abs(one.normal_force.value - both.normal_force.value) < 2.5 * one.normal_force.std
    assert abs(one.contact_radius.value - both.contact_radius.value) < 2.5 * one.contact_radius.std


def test_contact_is_made_by_force_alone(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    """At first touch the model's slope is zero; the filter must not stay in the air."""
    estimate = run(estimator, without(press(model, KNOTS, DEPTHS), "displacement"))
    assert estimate.in_contact
    assert estimate.indentation.value == pytest.approx(9e-4, rel=0.05)


def test_contact_breaks_and_returns(estimator: ContactEstimator, model: ContactModel, press: Record) -> None:
    knots = [0.0, 0.2, 0.5, 1.5, 1.6, 2.0, 2.3, 3.0]
    depths = [-1e-4, -1e-4, 9e-4, 9e-4, -2e-4, -2e-4, 7e-4, 7e-4]
    seen = [estimator.update(s).in_contact for s in press(model, knots, depths)]
    changes = np.flatnonzero(np.diff(np.array(seen, dtype=int))) / 500.0
    t = np.arange(len(seen)) / 500.0
    touching = model.simulate(t, np.interp(t, knots, depths)).normal_force > 0.02
    wanted = np.flatnonzero(np.diff(touching.astype(int))) / 500.0
    assert changes == pytest.approx(wanted, abs=0.02)


def test_limits_follow_the_exact_limit_surface(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS, share=0.3)
    states = [dataclasses.replace(s, torque_z=4e-4) for s in states]
    e = run(estimator, states)
    mu, N = e.friction_coefficient.value, e.normal_force.value
    a, k = e.contact_radius.value, e.pressure_exponent.value
    assert e.limit_force.value == pytest.approx(mu * N, rel=1e-12)
    torsion = float(reference.torsion_limit(k))
    assert e.limit_torque.value == pytest.approx(mu * N * a * torsion, rel=1e-4)
    psi = math.atan2(4e-4 / a, states[-1].tangential_force_x)
    wanted = mu * N * float(reference.radius(k, psi))
    assert e.limit_radius.value == pytest.approx(wanted, rel=1e-4)
    load = math.hypot(states[-1].tangential_force_x, 4e-4 / a)
    assert estimator.slip_margin().margin.value == pytest.approx(1.0 - load / wanted, rel=1e-3)


def test_spread_of_the_limit_force_has_all_its_parts(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    e = run(estimator, press(model, KNOTS, DEPTHS))
    parts = math.hypot(
        e.friction_coefficient.std / e.friction_coefficient.value, e.normal_force.std / e.normal_force.value
    )
    assert e.limit_force.std / e.limit_force.value == pytest.approx(parts, rel=1e-3)


@pytest.mark.parametrize(("R", "modulus", "scale"), [(2.5e-6, 2e3, "cell"), (0.2, 3e6, "tyre")])
def test_other_scales_are_not_special(R: float, modulus: float, scale: str, press: Record, run: Run) -> None:
    model = paper_model(R, modulus=modulus)
    peak = float(model.simulate([0.0, 0.5], [0.0, 0.11 * R]).normal_force[-1])
    noise = SensorNoise(0.01 * peak, 6e-4 * R, 0.01 * peak, 1e-4 * peak * R)
    estimator = ContactEstimator(model, noise, EstimatorSettings(friction=COULOMB))
    true = model.with_value("K", 1.4 * model.values["K"].value)
    depths = [0.11 * R * d / 9e-4 for d in DEPTHS]
    states = press(true, KNOTS, depths, share=0.4, noise=noise)
    e = run(estimator, states)
    assert e.indentation.value == pytest.approx(0.11 * R, rel=0.02)
    assert estimator.value("K").value == pytest.approx(1.4 * model.values["K"].value, rel=0.08)
    assert 0.0 < estimator.slip_margin().lower_bound < estimator.slip_margin().margin.value < 1.0


@pytest.mark.parametrize(
    ("shown", "channel"),
    [
        (Shown(), ""),
        (Shown(depth=1.2e-3, speed=1.0, load=50.0), ""),
        (Shown(depth=6e-4), "displacement"),
        (Shown(load=0.3), "normal_force"),
        (Shown(coldest=0.0, warmest=10.0), "temperature"),
    ],
)
def test_health_says_that_a_contact_is_beyond_what_the_model_was_fitted_over(
    model: ContactModel, press: Record, run: Run, shown: Shown, channel: str
) -> None:
    estimator = ContactEstimator(dataclasses.replace(model, shown=shown), SensorNoise())
    run(estimator, press(model, KNOTS, DEPTHS))
    health = estimator.health()
    assert health.consistent
    assert (health.channel, health.regime) == (channel, BEYOND_FIT if channel else "")


@pytest.mark.parametrize(
    ("depths", "channel"), [([-2e-3, -2e-3, -1e-3], ""), ([-1e-4, -1e-4, 9e-4], "displacement")]
)
def test_how_fast_a_tip_moves_is_beyond_what_was_fitted_only_while_it_touches(
    model: ContactModel, press: Record, run: Run, depths: list[float], channel: str
) -> None:
    """At 2 mm/s, fitted up to 0.1 mm/s."""
    estimator = ContactEstimator(dataclasses.replace(model, shown=Shown(speed=1e-4)), SensorNoise())
    run(estimator, press(model, [0.0, 0.3, 0.8], depths))
    assert estimator.health().channel == channel


@pytest.mark.parametrize(
    ("refused", "channel"), [(0, "normal_force"), (1, "displacement"), (7, "displacement")]
)
def test_an_estimate_that_is_lost_is_so_by_the_displacement_where_its_last_one_was_refused(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run, refused: int, channel: str
) -> None:
    run(estimator, press(model, KNOTS, DEPTHS))
    estimator.named["MODE_LOST"], estimator.named["DISPLACEMENT_STREAK"] = 0.2, float(refused)
    health = estimator.health()
    assert (health.channel, health.regime) == (channel, LOST)


@pytest.mark.parametrize(
    ("value", "std", "number", "most", "channel"),
    [
        ("REP_DEPTH_NOW", "REP_DEPTH_STD", 1.0, 1e-3, "displacement"),
        ("MOTION_SPEED", "MOTION_VAR_SPEED", -1.0, 0.1, "displacement"),
        ("REP_FORCE", "REP_FORCE_STD", 1.0, 10.0, "normal_force"),
    ],
)
def test_a_contact_is_beyond_what_was_fitted_by_a_quarter_and_two_standard_deviations(
    model: ContactModel, value: str, std: str, number: float, most: float, channel: str
) -> None:
    fitted = dataclasses.replace(model, shown=Shown(depth=1e-3, speed=0.1, load=10.0))
    estimator = ContactEstimator(fitted, SensorNoise())
    m = estimator.named
    m["REP_CONTACT"] = m["REP_SOUND"] = 1.0
    m[std] = (0.1 * most) ** 2 if "VAR" in std else 0.1 * most
    for share, told in ((1.449, ""), (1.451, channel)):
        m[value] = number * share * most
        assert estimator._beyond() == told
    m["REP_SOUND"] = 0.0
    assert estimator._beyond() == ""


def test_a_margin_spreads_by_what_is_estimated_and_by_the_noise_of_the_load(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    run(estimator, press(model, [0.0, 0.2, 0.4], [-1e-4, 9e-4, 9e-4], share=0.4))
    gauge, relative, noise = (estimator.named[f"REP_GAUGE{name}"] for name in ("", "_REL", "_ABS"))
    margin = estimator.slip_margin().margin
    assert margin.value == 1.0 - gauge
    assert margin.std == pytest.approx(math.hypot(gauge * relative, noise))
    assert estimator.value("K").age == 0.0


def test_friction_at_a_load_is_that_of_the_law_and_any_confidence_has_a_quantile(
    estimator: ContactEstimator,
) -> None:
    names = ("LN_MU", "VAR", "EXPONENT", "EXPONENT_VAR", "COV", "LOAD")
    for name, value in zip(names, (-0.5, 0.04, 0.2, 0.02, -0.01, 0.8), strict=True):
        estimator.named[f"FRI_{name}"] = value
    assert estimator.friction == pytest.approx((-0.5 - 0.16, 0.04 + 2.0 * 0.008 + 0.64 * 0.02))
    assert estimator.friction_law == (-0.5, 0.04, 0.2, 0.02)
    found = [quantile(confidence) for confidence in (0.0, 0.5, 0.95, 1.0)]
    assert found == pytest.approx([-5.997807015, 0.0, 1.644853627, 5.997807015], abs=1e-6)


def test_health_names_the_channel_that_does_not_fit(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    states = press(model, KNOTS, DEPTHS)
    run(estimator, states)
    assert estimator.health().consistent
    estimator.reset()
    rng = np.random.default_rng(5)
    noisier = [
        dataclasses.replace(s, normal_force=s.normal_force + 0.03 * rng.standard_normal()) for s in states
    ]
    run(estimator, noisier)
    health = estimator.health()
    assert not health.consistent
    assert health.channel == "normal_force"


def test_the_verdict_on_a_sample_is_reached_once_and_stays_until_the_next(
    estimator: ContactEstimator,
    model: ContactModel,
    press: Record,
    run: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks = 0

    def counted(verdict: HealthHysteresis, *given: Any) -> int:
        nonlocal looks
        looks += 1
        return update(verdict, *given)

    update = HealthHysteresis.update
    monkeypatch.setattr(HealthHysteresis, "update", counted)
    states = press(model, KNOTS, DEPTHS)
    run(estimator, states[:-1])
    assert estimator.health() == estimator.health()
    assert looks == 1
    run(estimator, states[-1:])
    estimator.health()
    assert looks == 2
    estimator.named.section("CHANNEL").reshape(3, -1)[:, 1] = 2.0
    estimator.reset_health()
    assert not estimator.health().consistent, "nothing is known any more"
    assert estimator.health().rejected == 0
    assert not estimator.named.section("HEALTH").any()


def test_before_the_first_sample_nothing_is_told_but_what_the_model_believes(
    estimator: ContactEstimator, model: ContactModel
) -> None:
    told = (estimator.health(), estimator.slip_margin(), estimator.contact_estimate())
    assert [(one.stamp, one.finger, one.seq) for one in told] == [(0, "", 0)] * 3
    assert estimator.lost == 0.0
    assert estimator.normal_force == UNKNOWN
    for place, symbol in enumerate(model.parameters):
        believed = model.values[symbol]
        found = estimator.value(symbol)
        assert found.value == pytest.approx(believed.value)
        assert found.std == pytest.approx(believed.std) or place in estimator.layout.learned
        assert not found.valid


def test_filter_in_plain_python_agrees_with_the_compiled_one(
    model: ContactModel, press: Record, compiled: ContactEstimator
) -> None:
    plain = module_for(model, compiled.layout, plain=True)
    fast, slow = compiled._blank.copy(), compiled._blank.copy()
    for i, s in enumerate(press(model, [0.0, 0.1, 0.2], [-5e-5, 5e-4, 5e-4])):
        sample = (
            -1.0 if i == 0 else 2e-3, s.normal_force, s.displacement, NAN, s.tangential_force_x, 0.0, 0.0
        )  # fmt: skip
        compiled._module.update(fast, *sample)
        plain.update(slow, *sample)
    places = compiled.layout.places()
    for section in ("Y", "P", "REPORT", "FRICTION"):
        np.testing.assert_allclose(
            fast[slice(*places[section])], slow[slice(*places[section])], rtol=1e-5, atol=1e-18
        )
