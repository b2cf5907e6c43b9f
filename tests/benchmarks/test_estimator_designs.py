"""The designs of the estimator are judged on the same recordings, against the best possible."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import estimator_designs
from benchmarks._designs_contact import BIAS, LEARNED, LN_K, STATES
from benchmarks._designs_particles import particle_filtered
from benchmarks._designs_recordings import drawn, pressed
from benchmarks._designs_reference import most_probable, traced, with_the_prior


@pytest.mark.slow
@pytest.mark.long
def test_every_design_gives_finite_figures_beside_the_product() -> None:
    rows = estimator_designs.run(recordings=1)
    others = [f"estimator_vs_{name}" for name in estimator_designs.DESIGNS if name != "product"]
    assert list(rows) == [*others, "estimator_designs"]
    assert all(math.isfinite(value) for row in rows.values() for value in row.values())
    for row in rows.values():
        assert row["ratio"] == pytest.approx(row["theirs_us"] / row["ours_us"])


@pytest.mark.long
def test_the_product_is_near_the_best_possible() -> None:
    judged = estimator_designs.judge(drawn(1))
    assert judged["product"]["N_ratio"] < 1.5
    assert judged["product"]["x_ratio"] < 1.5
    assert judged["product"]["not_valid"] == 0.0


@pytest.mark.slow
def test_the_reference_with_the_truth_has_honest_intervals() -> None:
    rows = [estimator_designs.judge(drawn(seed, presses=3))["truth"] for seed in (0, 1)]
    for quantity in ("N", "x"):
        assert 85.0 < np.mean([row[f"{quantity}_inside"] for row in rows]) <= 100.0


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_exact_step_agrees_with_a_direct_integration_through_release_and_touch(seed: int) -> None:
    recording = drawn(seed)
    unknowns = np.zeros(BIAS - LN_K + 2)
    unknowns[:4] = recording.parameters
    force, _, _ = traced(unknowns, recording.t, recording.indentation, recording.tip_radius / 10.0)
    assert np.max(np.abs(force - recording.true_force)) < 1e-4 * np.max(recording.true_force)


def test_a_held_press_relaxes_to_the_share_that_does_not_relax() -> None:
    t = np.arange(0.0, 20.0, 1e-3)
    true = np.array([0.0, 1.5, 0.3, math.log(3.0)])
    force = pressed(t, np.full(t.size, 1e-3), true, 1e-3)
    assert force[-1] == pytest.approx(0.7, rel=1e-3)


def test_noise_of_the_displacement_does_not_bias_the_reference_with_the_prior() -> None:
    """A slope at the displacement as measured is correlated with the residual."""
    recording = drawn(1, presses=6)
    noise = np.array([2e-5, 0.01])
    error = noise[0] * np.random.default_rng(5).standard_normal(recording.t.size)
    r = replace(recording, noise=noise, displacement=recording.indentation + error)
    _, mean, prior = estimator_designs.told(r)
    centre = np.append(mean[LEARNED], 0.0)
    weight = 1.0 / np.append(prior[LEARNED], noise[0] ** 2)
    depth = r.tip_radius / 10.0
    u, information, _, _ = most_probable(
        centre, r.t, r.displacement, r.normal_force, depth, noise, centre, weight
    )
    off = (u[:4] - r.parameters) / np.sqrt(np.diag(np.linalg.inv(information)))[:4]
    assert np.max(np.abs(off)) < 3.0


@pytest.mark.slow
def test_the_particle_filter_agrees_with_the_fit_of_all_data_about_the_same_posterior() -> None:
    """Two computations that share no more than the equations of the contact."""
    recording = drawn(1, presses=2)
    r, (model, mean, prior) = recording, estimator_designs.told(recording)
    felt = np.flatnonzero(r.true_force > 0.3)
    looks = felt[[felt.size // 4, felt.size // 2, -1]]
    given = (model.reference_depth, r.noise, mean[:STATES], prior[:STATES])
    upto = slice(0, looks[-1] + 1)
    particles = particle_filtered(r.t[upto], r.displacement[upto], r.normal_force[upto], *given)[looks]
    fits = with_the_prior(r.t, r.displacement, r.normal_force, *given, looks.tolist())
    std = fits[:, 1::2]
    assert np.max(np.abs(particles[:, ::2] - fits[:, ::2]) / std) < 0.7
    assert np.max(np.abs(np.log(particles[:, 1::2] / std))) < 0.35
