"""How N, a, k and friction spread, and whether what is published agrees with what was measured."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

NOW = (2.0, 3e-3, 2.5, 0.6)
W = math.sqrt(3.0)


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_step_is_slight_up_to_two_percent_of_each_and_where_the_exponent_moves(
    kernels, place, sign
) -> None:
    for share, slight in ((0.0199, True), (0.0201, False)):
        up = [value * (1.0 + 1e-3) for value in NOW]
        up[place] = NOW[place] * (1.0 + sign * share)
        assert kernels.is_slight(NOW, tuple(up)) == slight
    assert not kernels.is_slight(NOW, (*NOW[:2], NOW[2], NOW[3]))
    assert kernels.is_slight((50.0,) * 4, (51.0,) * 4)  # two percent to the last bit
    changed = [value + 1e-9 * (i == place) for i, value in enumerate(NOW)]
    assert kernels.is_unchanged(NOW, NOW)
    assert not kernels.is_unchanged(NOW, tuple(changed))


def test_the_mirror_of_a_step_lies_as_far_on_the_other_side(kernels) -> None:
    up = (2.5, 2e-3, 3.0, 0.7)
    assert_allclose(np.array(kernels.mirror_step(NOW, up)) + up, 2.0 * np.array(NOW))


@pytest.mark.parametrize(("up", "down", "exponent"), [(3.1, 2.4, 0.6), (2.7, 2.1, 0.4), (2.0, 2.4, -0.5)])
def test_a_column_is_the_slope_of_both_sides_of_the_exponent_the_larger(
    kernels, m, up, down, exponent
) -> None:
    kernels.note_difference(m, 2, (2.4, 5e-3, up, 0.8), (1.8, 4e-3, down, 0.3), 2.5)
    names = ("FORCE", "RADIUS", "EXPONENT", "FRICTION")
    column = [m[getattr(kernels, f"D_{name}0") + 2] for name in names]
    assert column == pytest.approx([0.3 / W, 0.5e-3 / W, exponent / W, 0.25 / W])


@pytest.mark.parametrize("bend", [0.0, 40.0])
def test_columns_are_differences_along_the_root_of_the_covariance(kernels, m, P, monkeypatch, bend) -> None:
    """Of a law that is straight, or bends so much that both sides are looked at."""
    n, moving = kernels.N, kernels.M
    weights = np.random.default_rng(4).uniform(0.5, 1.0, (4, n)) * 1e-6 / np.sqrt(np.diag(P) + 1e-30)

    asked = []

    def law(m, y):
        asked.append(y)
        z = weights @ (m[y : y + n] - m[kernels.Y0 : kernels.Y0 + n])
        return tuple(np.array(NOW) * (1.0 + z + bend * (1.0 + z) ** 2 * (z != 0.0)))

    monkeypatch.setattr(kernels, "quantities", law)
    assert kernels.spread_quantities(m) == pytest.approx(NOW)
    L = m[kernels.L0 : kernels.L0 + n * n].reshape(n, n)
    felt = np.array([bool(kernels.FELT[j]) for j in range(n)])
    assert_allclose((L @ L.T)[np.ix_(felt, felt)], P[np.ix_(felt, felt)], rtol=1e-6, atol=1e-18)
    for row, name in enumerate(("FORCE", "RADIUS", "FRICTION")):
        at = getattr(kernels, f"D_{name}0")
        place = row if row < 2 else 3
        base = NOW[place] * weights[place] @ L[:, :moving]
        expected = base * (1.0 + 2.0 * bend)
        assert_allclose(m[at : at + moving], expected, rtol=1e-3, atol=1e-12)
    at = kernels.D_DELTA0
    assert_allclose(m[at : at + moving], L[kernels.DELTA, :moving])
    columns = np.count_nonzero(np.diag(L)[:moving])
    assert len(asked) == 1 + columns * (2 if bend else 1)  # straight, one side is looked at
    assert m[kernels.D_FORCE0 + moving + kernels.N_CONSIDERED] == math.sqrt(m[kernels.MODE_TOLERATED])


def test_a_parameter_that_changes_nothing_is_looked_at_once_and_a_coordinate_twice(
    kernels, m, monkeypatch
) -> None:
    asked, moving, first = [], kernels.M, kernels.LEARNED_FROM
    monkeypatch.setattr(kernels, "quantities", lambda *_: asked.append(0) or (0.0, *NOW[1:]))
    m[kernels.MODE_TOLERATED] = 0.01
    kernels.spread_quantities(m)
    there = m[kernels.L0 : kernels.L0 + kernels.N * moving : kernels.N + 1] > 0.0
    assert len(asked) == 1 + 2 * np.count_nonzero(there[:first]) + np.count_nonzero(there[first:])
    assert m[kernels.D_FORCE0 + moving + kernels.N_CONSIDERED] == 0.0  # out of contact


def test_without_a_displacement_a_parameter_moves_the_depth_and_never_the_force(
    kernels, m, monkeypatch
) -> None:
    """At constant force the depth follows each parameter by the slope of its own."""
    first, moving, n = kernels.LEARNED_FROM, kernels.M, kernels.N
    m[kernels.MODE_BLIND] = 1.0
    monkeypatch.setattr(kernels, "slope_at_constant_force", lambda _m, _y, j: 1e-4 * (j + 1.0))
    kernels.square_root(m, kernels.P0)
    L = m[kernels.L0 : kernels.L0 + n * n].reshape(n, n).copy()
    kernels.spread_quantities(m)
    slopes = np.where((np.arange(n) >= first) & (np.arange(n) < moving), 1e-4 * (np.arange(n) + 1.0), 0.0)
    moved = L[kernels.DELTA, :moving] + (slopes @ L)[:moving] * (np.arange(moving) >= first)
    assert_allclose(m[kernels.D_DELTA0 : kernels.D_DELTA0 + moving], moved, rtol=1e-9)
    force = m[kernels.D_FORCE0 : kernels.D_FORCE0 + moving]
    assert not force[first:].any()
    assert force[kernels.DELTA] > 0.0


def test_quantities_are_those_that_the_model_reads_from_depth_speed_and_states(
    kernels, m, monkeypatch
) -> None:
    """Friction at this force: that of the model times its fall from 5 N on."""
    given, y = [], kernels.Y0
    monkeypatch.setattr(kernels, "readout", lambda _m, *one: given.append(one) or (3e-3, 2.5, 0.6))
    m[kernels.FRI_EXPONENT], m[y + kernels.SPEED] = 0.3, 0.02
    x, elastic, force, _ = kernels.contact(m, y)
    expected = (force, 3e-3, 2.5, 0.6 * (force / 5.0) ** -0.3)
    assert kernels.quantities(m, y) == pytest.approx(expected)
    depth = m[y + kernels.DELTA]
    rest = (depth, 0.02, kernels.EXOGENOUS0, x, elastic, force)
    assert given == [(kernels.VALUES0, kernels.TRIAL0, *rest)]


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("std", [1e-4, 0.3])
def test_parameters_that_are_not_learned_spread_by_their_own_standard_deviation(
    kernels, m, monkeypatch, std, log
) -> None:
    count, first = kernels.CONSIDERED_MU, kernels.M
    monkeypatch.setattr(kernels, "CONSIDERED_LOG", (log,) * (count + 1))
    kept = m.copy()
    m[kernels.FRI_VAR], m[kernels.FRI_EXPONENT] = std * std, 0.3
    m[kernels.D_DELTA0 + first : kernels.D_DELTA0 + first + count + 1] = 7.0
    for i in range(count):
        m[kernels.CONSIDER0 + i] = std * std

    def readout(m, values, *_):
        product = math.prod(m[values + kernels.CONSIDERED[i]] for i in range(count))
        return 2.0 * product, 3.0 * product, 4.0 * product

    monkeypatch.setattr(kernels, "readout", readout)
    force = kernels.contact(m, kernels.Y0)[2]
    a, k, friction = readout(m, kernels.VALUES0)
    now = (force, a, k, friction * (force / 5.0) ** -0.3)
    kernels.spread_considered(m, now)
    for i in range(count):
        value, sd = m[kernels.VALUES0 + kernels.CONSIDERED[i]], W * std
        up, down = (
            (math.exp(s * sd) if kernels.CONSIDERED_LOG[i] else 1.0 + s * sd / value) for s in (1.0, -1.0)
        )
        slope = (up - down) / (2.0 * W)
        assert m[kernels.D_RADIUS0 + first + i] == pytest.approx(now[1] * slope, rel=1e-3)
        assert m[kernels.D_FRICTION0 + first + i] == pytest.approx(now[3] * slope, rel=1e-3)
        assert m[kernels.D_FORCE0 + first + i] == m[kernels.D_DELTA0 + first + i] == 0.0
        assert value == kept[kernels.VALUES0 + kernels.CONSIDERED[i]]
    assert m[kernels.D_FRICTION0 + first + count] == pytest.approx(now[3] * std)
    for name in ("RADIUS", "FORCE", "EXPONENT", "SHAPE", "DELTA"):
        assert m[getattr(kernels, f"D_{name}0") + first + count] == 0.0


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("channel", ["force", "displacement", "radius"])
def test_an_estimate_five_standard_deviations_off_for_two_samples_is_not_sound(
    kernels, m, channel, sign
) -> None:
    m[kernels.REP_FORCE_STD], m[kernels.REP_DEPTH_STD], m[kernels.REP_RADIUS_STD] = 0.1, 3e-6, 3e-5
    m[kernels.SET_R_DISPLACEMENT], m[kernels.SET_R_RADIUS] = (4e-6) ** 2, (4e-5) ** 2
    right = {
        "force": m[kernels.REP_FORCE] + m[kernels.Y0 + kernels.BIAS],
        "displacement": m[kernels.REP_DEPTH_NOW] + m[kernels.Y0 + kernels.OFFSET],
        "radius": m[kernels.REP_RADIUS],
    }
    std = {"force": 0.1, "displacement": 5e-6, "radius": 5e-5}[channel]
    for stds, sound in ((4.99, True), (5.01, False)):
        m[kernels.MODE_CONTRADICTED] = m[kernels.MODE_RADIUS_CONTRADICTED] = m[kernels.MODE_LOST] = 0.0
        measured = right | {channel: right[channel] + sign * stds * std}
        for sample in range(3):
            m[kernels.REP_SOUND] = 1.0
            kernels.note_contradiction(m, 0.01, *measured.values())
            lasts = sound or sample < 2  # the first begins it, after 15 ms it counts
            assert m[kernels.REP_RADIUS_SOUND] == float(lasts)
            assert m[kernels.REP_SOUND] == float(lasts or channel == "radius")
    kernels.note_contradiction(m, 0.01, *right.values())
    assert m[kernels.MODE_CONTRADICTED] == m[kernels.MODE_RADIUS_CONTRADICTED] == 0.0


def test_what_is_lost_for_15_ms_is_not_sound_and_what_is_not_measured_contradicts_nothing(kernels, m) -> None:
    for lost, sound in ((0.0149, 1.0), (0.0151, 0.0)):
        m[kernels.MODE_LOST], m[kernels.REP_SOUND] = lost, 1.0
        kernels.note_contradiction(m, 0.01, math.nan, math.nan, math.nan)
        assert (m[kernels.REP_SOUND], m[kernels.MODE_CONTRADICTED]) == (sound, 0.0)


@pytest.mark.parametrize(("measured", "estimated"), [(5e-3, 0.0), (0.0, 5e-3), (math.nan, 5e-3)])
def test_no_radius_contradicts_none(kernels, m, measured, estimated) -> None:
    m[kernels.REP_RADIUS], m[kernels.REP_RADIUS_STD] = estimated, 1e-6
    m[kernels.MODE_RADIUS_CONTRADICTED] = 0.0
    m[kernels.REP_SOUND], m[kernels.MODE_CONTRADICTED], m[kernels.MODE_LOST] = 1.0, 0.0, 0.0
    kernels.note_contradiction(m, 0.02, math.nan, math.nan, measured)
    assert (m[kernels.MODE_RADIUS_CONTRADICTED], m[kernels.REP_RADIUS_SOUND]) == (0.0, 1.0)


@pytest.mark.parametrize("force", [1e-3, 0.5, 3.0])
def test_what_is_unexplained_may_be_wrong_of_any_force_of_a_contact_and_of_none_in_the_air(
    kernels, m, force
) -> None:
    m[kernels.MODE_TOLERATED] = 0.09
    last = kernels.D_FORCE0 + kernels.M + kernels.N_CONSIDERED
    kernels.spread_unexplained(m, force)
    assert m[last] == pytest.approx(0.3)
    kernels.spread_unexplained(m, 0.0)
    assert m[last] == 0.0
