"""The test bench for one fingertip."""

import numpy as np
import pytest

from vegrip.virtual.bench.protocol import Segment, creep, hold, sine, slip, standard_protocol, triangles
from vegrip.virtual.bench.trial import TRUTH, run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings, random_fingertip

TIP = FingertipSettings(bristle_stiffness=1e9)
NOISE = SensorSettings(rate=200.0, radius_sensor=True)


def run(*protocol, seed=0, noise=NOISE, **options):
    return run_trial(TIP, protocol, noise, seed, **options)


def test_same_seed_same_trial_bit_for_bit() -> None:
    first, second, other = (run(hold(1e-3, 0.5), seed=seed) for seed in (1, 1, 2))
    for name, values in first.columns.items():
        assert np.array_equal(values, second.columns[name])
    assert not np.array_equal(first.columns["normal_force"], other.columns["normal_force"])
    assert np.array_equal(first.truth["normal_force"], other.truth["normal_force"])


def test_columns_are_those_of_a_recording_at_the_stated_rate() -> None:
    trial = run(hold(1e-3, 0.5), creep(1.0, 0.5))
    assert set(trial.columns) == {
        "t", "episode", "displacement", "normal_force", "tangential_force_x", "tangential_force_y",
        "torque_z", "slip", "slip_speed", "temperature", "contact_radius",
    }  # fmt: skip
    assert set(trial.truth) == set(TRUTH)
    t, episode = trial.columns["t"], trial.columns["episode"]
    assert np.all(np.diff(t) > 0.0)
    assert np.diff(t)[np.diff(episode) == 0] == pytest.approx(5e-3)
    assert np.diff(t)[np.diff(episode) == 1] > 20.0


def test_measured_minus_true_is_the_sensor_noise() -> None:
    trial = run(hold(1e-3, 4.0))
    rest = trial.columns["normal_force"] - trial.truth["normal_force"]
    assert rest.std() == pytest.approx(NOISE.normal_force, rel=0.1)


def test_held_depth_is_held_and_held_force_is_held() -> None:
    depth = run(hold(1e-3, 2.0)).truth
    during = slice(100, 400)
    assert depth["indentation"][during] == pytest.approx(1e-3)
    assert np.all(np.diff(depth["normal_force"][during]) < 0.0)
    force = run(creep(1.0, 2.0)).truth
    assert force["normal_force"][during] == pytest.approx(1.0)
    assert np.all(np.diff(force["indentation"][during]) > 0.0)


def test_triangles_and_sines_go_where_they_are_told() -> None:
    depth = run(triangles(1e-3, 2e-3, 2)).truth["indentation"]
    assert depth.max() == pytest.approx(1e-3, rel=1e-3)
    assert np.sum((depth[1:-1] > depth[:-2]) & (depth[1:-1] >= depth[2:]) & (depth[1:-1] > 0.9e-3)) == 2
    wave = run(sine(1e-3, 2e-4, 1.0, 2)).truth["indentation"]
    assert wave.max() == pytest.approx(1.2e-3, rel=1e-3)


def test_pull_slides_at_coulomb_force_and_twist_at_the_limit_torque() -> None:
    pulled = run(slip(1.0, 0.2, pull=1e-3))
    sliding = pulled.columns["slip"] == 1.0
    assert 50 < sliding.sum() < 320
    assert pulled.truth["tangential_force"][sliding] == pytest.approx(0.8, rel=1e-3)
    assert pulled.truth["utilisation"][sliding] == pytest.approx(1.0, rel=1e-3)
    twisted = run(slip(1.0, 0.2, spin=1.0))
    sliding = twisted.columns["slip"] == 1.0
    assert sliding.any()
    assert twisted.truth["utilisation"][sliding] == pytest.approx(1.0, abs=2e-2)


def test_utilisation_never_exceeds_one_while_held() -> None:
    used = run(slip(1.0, 0.2, pull=2e-3, spin=0.5)).truth["utilisation"]
    assert used.max() <= 1.0 + 1e-3


def test_episodes_start_recovered() -> None:
    trial = run(hold(1e-3, 0.5), hold(1e-3, 0.5))
    first, second = (trial.truth["normal_force"][trial.columns["episode"] == e] for e in (0, 1))
    assert np.array_equal(first, second)


def test_finer_steps_change_little() -> None:
    coarse = run(hold(1e-3, 0.5)).truth["normal_force"]
    fine = run(hold(1e-3, 0.5), step=2.5e-4).truth["normal_force"]
    assert coarse == pytest.approx(fine, abs=2e-3 * fine.max())


def test_standard_protocol_has_every_kind_of_motion_for_any_tip() -> None:
    for radius in (1e-6, 1e-2):
        tip = FingertipSettings(
            radius=radius, reference_indentation=0.1 * radius, reference_force=1.2e4 * radius**2
        )
        segments: list[Segment] = [segment for episode in standard_protocol(tip) for segment in episode]
        assert max(s.depth or 0.0 for s in segments) == pytest.approx(0.2 * radius)
        for quantity in ("force", "amplitude", "pull_x", "spin"):
            assert any(getattr(s, quantity) for s in segments)


@pytest.mark.parametrize("seed", range(4))
def test_any_random_fingertip_gives_a_finite_trial_with_slips(seed) -> None:
    tip = random_fingertip(np.random.default_rng(seed))
    protocol = standard_protocol(tip)
    trial = run_trial(tip, (protocol[0], protocol[10], protocol[16]), NOISE, seed, step=2.5e-3)
    assert all(np.all(np.isfinite(values)) for values in (*trial.columns.values(), *trial.truth.values()))
    assert trial.columns["slip"][trial.columns["episode"] == 1].any()
    assert trial.truth["utilisation"].max() == pytest.approx(1.0, abs=0.01)
