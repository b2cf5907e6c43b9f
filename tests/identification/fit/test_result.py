"""What a fit says of its misfit."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from vegrip.identification.fit.problem import AT
from vegrip.identification.fit.result import (
    LAGS,
    Fit,
    _about_misfit,
    _about_unknown,
    _airless,
    _missing,
    channel_errors,
    whiteness,
)


@pytest.mark.parametrize(
    ("error", "tolerance", "said"),
    [
        (0.45, 0.0, ["too large"]),
        (0.55, 0.0, []),
        (1.05, 0.0, []),
        (1.15, 0.0, ["1.15 times the noise"]),
        (9.5, 0.0, ["9.50 times the noise"]),
        (10.5, 0.0, ["10.50 times the noise", "--tolerance 0.01"]),
        (10.5, 0.01, ["10.50 times the noise"]),
    ],
)
def test_what_is_left_of_the_noise_is_told_as_far_as_it_matters(error, tolerance, said) -> None:
    noise = SimpleNamespace(tolerance=tolerance)
    depth = 1e-3 * np.sin(np.linspace(0.0, np.pi, 200))
    columns = {"displacement": depth, "normal_force": 1e4 * depth**1.5}
    recording = SimpleNamespace(
        columns=columns, episode=np.zeros(200, dtype=np.int64), fingertip=SimpleNamespace(radius=9e-3)
    )
    problem = SimpleNamespace(measured=SimpleNamespace(noise=noise, recording=recording))
    channels = {"normal_force": SimpleNamespace(rmse=1e-3)}  # [N] of 0.3
    fit = SimpleNamespace(error=error, problem=problem, channels=channels)
    told = list(_about_misfit(fit, advise=False))
    assert len(told) == len(said)
    assert all(part in text for part, text in zip(said, told, strict=True))


def test_standard_errors_are_the_roots_of_the_variances() -> None:
    problem = SimpleNamespace(unknowns=SimpleNamespace(names=("K", "p", "c1")))
    fitted = SimpleNamespace(problem=problem, covariance=np.diag([0.04, 0.0, -1e-20]))
    assert Fit.std.fget(fitted) == pytest.approx({"K": 0.2, "p": 0.0, "c1": 0.0})


def test_each_channel_has_the_errors_of_its_rows() -> None:
    """Drawn noise of known size; a slip belongs to the load that is the larger part of its limit."""
    rng = np.random.default_rng(3)
    n, k, m = 4000, 600, 500
    force, slip, radius = (
        0.01 * rng.standard_normal(n),
        0.03 * rng.standard_normal(k),
        2e-5 * rng.standard_normal(m),
    )
    std, stiffness = np.full(n, 0.01), np.where(np.arange(n) < 3000, 800.0, 0.0)
    stiffness[:500] = 79.0  # of 800: too soft to read a displacement from
    table = np.zeros((n, len(AT)))
    sliding = np.arange(k)
    table[sliding, AT["tangential_force"]] = np.where(sliding < 400, -1.1, 0.9)
    table[sliding, AT["torque_z"]] = 1e-3
    table[sliding, AT["limit_force"]], table[sliding, AT["limit_torque"]] = 2.0, 2e-3
    raw = (force, slip, radius)
    counts = np.arange(n) >= 100
    slip_std = np.full(k, 0.03)
    slip_std[:50] = np.inf
    problem = SimpleNamespace(
        table=lambda _: table, raw=lambda _: raw, used=counts, stiffness=stiffness, force_std=std,
        white=lambda _: np.concatenate([force / 0.01, slip / 0.03, radius / 2e-5]),
        episodes=np.zeros(n), slip_std=slip_std, radius_std=np.full(m, 2e-5),
        measured=SimpleNamespace(recording=range(n), sliding=sliding, seen=np.arange(m)),
    )  # fmt: skip
    errors = channel_errors(problem, np.zeros(1))
    rows = {
        "normal_force": n - 100,
        "displacement": 2500,
        "tangential_force": 350,
        "torque_z": 200,
        "contact_radius": m,
    }
    noises = {"normal_force": 0.01, "displacement": 0.01 / 800, "tangential_force": 0.033, "torque_z": 3e-5,
              "contact_radius": 2e-5}  # fmt: skip
    assert {name: one.rows for name, one in errors.items()} == rows
    for name, one in errors.items():
        assert one.noise == pytest.approx(noises[name])
        assert one.rmse / one.noise == pytest.approx(one.ratio)
        assert one.ratio == pytest.approx(1.0, abs=0.12)
        assert one.coverage95 == pytest.approx(0.95, abs=0.03)
        assert one.whiteness_p > 1e-3
    stiffness[11:] = 0.0
    counts[:] = True
    assert "displacement" in channel_errors(problem, np.zeros(1))
    stiffness[10] = 0.0
    assert "displacement" not in channel_errors(problem, np.zeros(1))


def test_what_hangs_together_is_not_white_and_episodes_do_not_hang_together() -> None:
    rng = np.random.default_rng(1)
    values = rng.standard_normal(2000)
    one, each = np.zeros(2000), np.arange(2000)
    assert whiteness(values, one) > 1e-3
    assert whiteness(values + 0.5 * np.roll(values, 3), one) < 1e-6
    alternate = np.repeat(rng.standard_normal(1000), 2)  # pairs that are alike, in episodes of their own
    assert whiteness(alternate, one) < 1e-6
    assert whiteness(alternate, each) == 1.0
    r = np.correlate(values, values, "full")[1999:] / (values @ values)
    Q = 2000 * 2002 * np.sum(r[1 : LAGS + 1] ** 2 / (2000 - np.arange(1, LAGS + 1)))
    assert whiteness(values, one) == pytest.approx(chi2.sf(Q, LAGS))
    assert math.isnan(whiteness(values[: 3 * LAGS], one[: 3 * LAGS]))
    assert not math.isnan(whiteness(values[: 3 * LAGS + 1], one[: 3 * LAGS + 1]))
    assert math.isnan(whiteness(np.zeros(2000), one))


@pytest.mark.parametrize(
    ("at", "std", "transform", "said"),
    [
        (0.5, 0.71, "", "not determined"),
        (0.5, 0.69, "", ""),
        (0.0009, 0.1, "", "sits at 0"),
        (0.0011, 0.1, "", ""),
        (0.0009, 0.1, "log", "lower bound"),
        (3.9991, 0.1, "", "upper bound"),
        (3.9989, 0.1, "", ""),
        (-0.0009, 0.1, "", "sits at 0"),
    ],
)
def test_what_is_to_be_wary_of_in_a_value_is_said(at, std, transform, said) -> None:
    """A prior of one, bounds at 0 and 4."""
    k = SimpleNamespace(names=("pull",), std=np.ones(1), low=np.zeros(1), high=np.array([4.0]))
    declared = SimpleNamespace(name="adhesion"), SimpleNamespace(transform=transform)
    fit = SimpleNamespace(
        problem=SimpleNamespace(unknowns=k), optimum=SimpleNamespace(u=np.array([at])), std={"pull": std},
        declared=lambda _: declared,
    )  # fmt: skip
    told = list(_about_unknown(fit, 0, "pull"))
    assert len(told) == bool(said)
    assert all(said in text and "pull (adhesion)" in text for text in told)


@pytest.mark.parametrize(("at", "said"), [(0.4996, True), (-0.4996, True), (0.4994, False)])
def test_a_zero_on_its_bound_is_said(at, said) -> None:
    k = SimpleNamespace(high=np.array([0.5]))
    fit = SimpleNamespace(
        problem=SimpleNamespace(unknowns=k),
        optimum=SimpleNamespace(u=np.array([at])),
        declared=lambda _: None,
    )
    assert bool(list(_about_unknown(fit, 0, "zero_force"))) == said


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, ""),
        ({"sliding": 0}, "no row slides"),
        ({"touching": 49}, "only 49 rows are in contact"),
        ({"touching": 50}, ""),
        ({"deepest": 0.199}, "under 2 %"),
        ({"deepest": 0.201}, ""),
        ({"flat": 21}, "may saturate"),
        ({"flat": 20}, ""),
        ({"flat": 21, "equal": 11}, "may saturate"),
        ({"flat": 21, "equal": 10}, ""),
        ({"flat": 23, "rows": 12000}, ""),
        ({"flat": 25, "rows": 12000}, "may saturate"),
    ],
)
def test_what_a_recording_lacks_is_said(given, said) -> None:
    rows = {"sliding": 5, "touching": 500, "deepest": 0.5, "flat": 0, "equal": None, "rows": 2000} | given
    force = np.linspace(0.0, 2.0, rows["rows"])
    flat, equal = rows["flat"], rows["equal"]
    if flat:
        force[-flat:] = 2.1 - 0.0049
        force[-(flat if equal is None else equal) :] = 2.1
    measured = SimpleNamespace(
        sliding=np.arange(rows["sliding"]),
        motion=SimpleNamespace(displacement=1e-3 * np.linspace(0.0, rows["deepest"], 100)),
        force=force,
        noise=SimpleNamespace(normal_force=0.01),
    )
    stiffness = np.r_[np.zeros(10), np.ones(rows["touching"])]
    problem = SimpleNamespace(measured=measured, stiffness=stiffness, depth=1e-3)
    told = list(_missing(SimpleNamespace(problem=problem)))
    assert len(told) == bool(said)
    assert all(said in text for text in told)


def test_a_tip_that_is_never_in_the_air_is_said() -> None:
    table = np.ones((5, len(AT)))
    fit = SimpleNamespace(problem=SimpleNamespace(table=lambda _: table), optimum=SimpleNamespace(u=None))
    assert len(list(_airless(fit))) == 1
    table[2, AT["contact_radius"]] = 0.0
    assert list(_airless(fit)) == []


def test_pairs_that_hang_together_are_told_strongest_first() -> None:
    C = np.array([[4.0, 1.9, 0.0], [1.9, 1.0, -0.93], [0.0, -0.93, 1.0]])
    problem = SimpleNamespace(unknowns=SimpleNamespace(names=("K", "p", "c1")))
    fit = SimpleNamespace(problem=problem, covariance=C)
    told = [("p", "K", pytest.approx(0.95)), ("c1", "p", pytest.approx(-0.93))]
    assert Fit.correlations(fit) == told
    assert Fit.correlations(fit, 0.94) == told[:1]
    assert Fit.correlations(fit, 0.96) == []
