"""What a fit promises, on recordings by the model itself: cheap ones, so that many can be made."""

import numpy as np
import pytest

from vegrip.identification.fit import fit
from vegrip.identification.fit.problem import AT
from vegrip.identification.recording import Fingertip, Recording
from vegrip.model import paper_model
from vegrip.parameters import coordinate

TRUE = (
    paper_model(0.01).with_value("K", 1.5).with_value("p", 1.6).with_value("c1", 0.35).with_value("nu1", 1.5)
)
NORMAL = ("K", "p", "c1", "nu1")
SENSORS = {"normal_force": 5e-3, "displacement": 3e-6}


def press(seed: int, *, pause: float = 20.0, radius: float = 0.01, memory: bool = False) -> Recording:
    """Three presses ``pause`` [s] apart; with ``memory`` the contact has not recovered in between."""
    rng = np.random.default_rng(seed)
    times, depths, episodes, forces = [], [], [], []
    for i, deep in enumerate((0.6e-3, 1.2e-3, 0.9e-3)):
        t = np.arange(0.0, 3.0, 0.01)
        depths.append(np.interp(t, [0.0, 0.2, 0.4, 2.4, 2.6, 3.0], [-1e-4, -1e-4, deep, deep, -1e-4, -1e-4]))
        times.append(t + i * (3.0 + pause))
        episodes.append(np.full(t.size, i))
        forces.append(TRUE.simulate(t, depths[-1]).normal_force)
    t, depth = np.concatenate(times), np.concatenate(depths)
    force = TRUE.simulate(t, depth).normal_force if memory else np.concatenate(forces)
    columns = {
        "displacement": depth + SENSORS["displacement"] * rng.standard_normal(t.size),
        "normal_force": force + SENSORS["normal_force"] * rng.standard_normal(t.size),
    }
    source = {"recovered": False} if memory else {}
    return Recording("press", t, np.concatenate(episodes), columns, Fingertip(radius), SENSORS, source)


def off(found, name: str) -> float:
    """Distance from the truth in standard errors."""
    _, declared = found.declared(name)
    value, true = (coordinate(declared, m.values[name].value) for m in (found.model, TRUE))
    return (value - true) / found.std[name]


@pytest.mark.slow
def test_standard_errors_cover_the_truth() -> None:
    z = np.array([[off(found, name) for name in NORMAL] for found in (fit(press(s)) for s in range(16))])
    rms = np.sqrt(np.mean(z**2, axis=0))
    assert np.all(rms > 0.5), dict(zip(NORMAL, rms, strict=True))  # of 16 draws 99.9 % lie in 0.5 .. 1.6
    assert np.all(rms < 1.6), dict(zip(NORMAL, rms, strict=True))
    assert np.mean(np.abs(z) < 1.96) > 0.88


@pytest.mark.slow
def test_one_row_in_a_hundred_wild_hardly_moves_the_fit() -> None:
    clean = press(3)
    rng = np.random.default_rng(4)
    columns = {name: values.copy() for name, values in clean.columns.items()}
    for name, size in (("normal_force", 0.5), ("displacement", 2e-4)):
        rows = rng.choice(len(clean), len(clean) // 100, replace=False)
        columns[name][rows] += size * rng.choice([-1.0, 1.0], rows.size)
    wild = Recording("wild", clean.t, clean.episode, columns, clean.fingertip, clean.sensors)
    one, other = fit(clean), fit(wild)
    for name in NORMAL:
        apart = abs(off(one, name) - off(other, name))
        assert apart < 1.5, name
    assert other.problem.measured.outliers["normal_force"] >= 0.8 * (len(clean) // 100)


@pytest.mark.slow
def test_a_wrong_radius_moves_no_relaxation_and_scales_the_stiffness() -> None:
    right, wrong = fit(press(5)), fit(press(5, radius=0.02))
    for name in ("p", "c1", "nu1"):
        assert wrong.model.values[name].value == pytest.approx(right.model.values[name].value, rel=0.01)
    deeper = (0.02 / 0.01) ** right.model.values["p"].value  # K is the force at a tenth of the radius
    assert wrong.model.values["K"].value / right.model.values["K"].value == pytest.approx(deeper, rel=0.02)


@pytest.mark.parametrize(("since", "does_begin_pressed"), [(0.0, False), (0.8, True)])
def test_what_begins_pressed_is_known_by_the_sensor_even_if_a_zero_makes_a_preload_of_the_air(
    since: float, does_begin_pressed: bool
) -> None:
    whole = press(1)
    problem = fit(whole.select((whole.episode == 0) & (whole.t >= since))).problem
    u = problem.unknowns.start.copy()
    u[problem.unknowns.names.index("zero_displacement")] = -1.0
    assert problem.table(u)[0, AT["indentation"]] > 0.0
    assert problem.doubted(u)[:20].any() == does_begin_pressed


def test_what_parted_without_a_load_leaves_no_dent_even_if_a_zero_makes_a_contact_of_the_air() -> None:
    """Away from a surface that is taken for higher than it is, the tip parts, and each row after is kept."""
    t = np.arange(0.0, 4.0, 0.01)
    depth = np.interp(t, [0.0, 0.2, 0.6, 0.8, 2.8, 3.0, 4.0], [-1e-6, -1e-4, -1e-4, 1e-3, 1e-3, -1e-4, -1e-4])
    columns = {"displacement": depth, "normal_force": TRUE.simulate(t, depth).normal_force}
    problem = fit(Recording("away", t, np.zeros(t.size, int), columns, Fingertip(0.01), SENSORS)).problem
    u = problem.unknowns.start.copy()
    u[problem.unknowns.names.index("zero_displacement")] = -0.05
    out, touches = problem.table(u), problem.table(u)[:, AT["indentation"]] > 0.0
    assert touches[0]
    assert (touches & (out[:, AT["contact_radius"]] == 0.0))[:40].any()  # parted in the air
    assert not problem.doubted(u)[t < 2.8].any()


@pytest.mark.slow
def test_a_contact_that_has_not_recovered_is_fitted_with_its_memory() -> None:
    recording = press(6, pause=0.3, memory=True)
    found = fit(recording)
    assert found.error == pytest.approx(1.0, abs=0.05)
    for name in NORMAL:
        assert abs(off(found, name)) < 4.0, name
    denied = Recording(
        "denied", recording.t, recording.episode, recording.columns, recording.fingertip, SENSORS
    )
    assert fit(denied).error > 1.15
