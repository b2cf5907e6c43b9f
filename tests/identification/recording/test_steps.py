"""Unit steps of a material: what relaxation and creep of one material say by themselves and together.

The creep that goes with a relaxation is found here by Volterra's equation, ``int G(t - s) dJ(s) = 1``, step
by step, which shares nothing with the fit.
"""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vegrip.errors import RecordingError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.error_ladder import add_effect
from vegrip.identification.fit import fit, noise_of
from vegrip.identification.fit.result import Fit
from vegrip.identification.recording import Kind, Recording, read_recording, write_recording
from vegrip.identification.recording.column_map import ColumnMap, with_columns
from vegrip.identification.recording.data import join_recordings
from vegrip.identification.recording.import_csv import import_csv
from vegrip.types import Floats

Law = Callable[[Floats], Floats]
MODULUS = 2e5  # [Pa] at once
T = np.geomspace(0.01, 100.0, 160)
FINE = np.r_[0.0, np.geomspace(1e-4, 100.0, 2000)]


def two_times(t: Floats) -> Floats:
    return MODULUS * (0.5 + 0.3 * np.exp(-3.0 * t) + 0.2 * np.exp(-0.1 * t))


def power_law(t: Floats) -> Floats:
    """The spectrum ``nu^0.2`` over ln nu from 0.0046 to 215 1/s, by quadrature."""
    ln_nu = np.linspace(np.log(0.01) - np.log(10.0) / 3.0, np.log(100.0) + np.log(10.0) / 3.0, 801)
    weight = np.exp(0.2 * ln_nu)
    left = np.exp(-t[:, None] * np.exp(ln_nu)) @ (weight / weight.sum())
    return MODULUS * (0.4 + 0.6 * left)


def creep(law: Law, t: Floats) -> Floats:
    J = np.r_[1.0 / law(np.zeros(1)), np.zeros(FINE.size - 1)]
    for i in range(1, FINE.size):
        g = law(FINE[i] - FINE[: i + 1])
        mean = 0.5 * (g[1:] + g[:-1])
        J[i] = J[i - 1] + (1.0 - J[0] * g[0] - mean[:-1] @ np.diff(J[:i])) / mean[-1]
    return np.interp(t, FINE, J)


def table(path: Path, head: str, *columns: Floats) -> Path:
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="")
    return path


def step(tmp_path: Path, law: Law, kind: str, noise: float = 0.002, seed: int = 1) -> Recording:
    exact = law(T) if kind == "Relaxation Modulus" else creep(law, T)
    measured = exact * (1.0 + noise * np.random.default_rng(seed).standard_normal(T.size))
    return import_csv(table(tmp_path / f"{kind[:5]}.csv", f"Time,{kind}", T, measured), is_step=True)


def fitted(recording: Recording, effect: str) -> Fit:
    noise = noise_of(recording)
    found, _ = add_effect(effect, fit(recording, noise=noise))
    return found


def test_a_step_that_is_held_hides_no_motion_where_rows_are_missing(tmp_path: Path) -> None:
    whole = step(tmp_path, two_times, KINDS[0])
    lost = whole.select((whole.t < 1.0) | (whole.t > 3.0))
    assert not fit(lost).problem.measured.gaps.size


KINDS = ("Relaxation Modulus", "Creep Compliance")
LAWS = {
    "second_relaxation": (two_times, {"K": 0.2, "c1": 0.3, "nu1": 3.0, "c2": 0.2, "nu2": 0.1}),
    "power_law_relaxation": (power_law, {"K": 0.2}),
}


@pytest.mark.parametrize("kinds", [KINDS[:1], KINDS[1:], KINDS])
def test_two_relaxation_times_are_found_in_relaxation_in_creep_and_in_both(
    tmp_path: Path, kinds: tuple[str, ...]
) -> None:
    law, truth = LAWS["second_relaxation"]
    parts = [step(tmp_path, law, kind, seed=i) for i, kind in enumerate(kinds)]
    found = fitted(join_recordings(parts, "both"), "second_relaxation")
    values = {name: found.model.values[name].value for name in truth}
    assert found.error < 1.1
    assert values == pytest.approx(truth, rel=0.03)


@pytest.mark.parametrize(
    "effect",
    [pytest.param(one, marks=pytest.mark.long) if one == "power_law_relaxation" else one for one in LAWS],
)
def test_relaxation_and_creep_of_one_material_agree(tmp_path: Path, effect: str) -> None:
    relaxed, crept = (fitted(step(tmp_path, LAWS[effect][0], kind, 0.005), effect) for kind in KINDS)
    t = np.r_[0.0, T]
    one, other = (
        f.model.simulate(np.r_[-1e-6, t] + 1e-6, np.r_[0.0, np.ones(t.size)]) for f in (relaxed, crept)
    )
    exact = LAWS[effect][0](t[1:]) / 1e6  # a strain of 1 of a section of 1 mm^2
    np.testing.assert_allclose(one.normal_force[2:], exact, rtol=0.015)
    np.testing.assert_allclose(other.normal_force[2:], exact, rtol=0.015)


def test_a_creep_that_is_of_another_material_is_unexplained(tmp_path: Path) -> None:
    def slower(t: Floats) -> Floats:
        return two_times(0.2 * t)

    parts = [step(tmp_path, two_times, KINDS[0]), step(tmp_path, slower, KINDS[1])]
    assert diagnose(join_recordings(parts, "two"), threads=1).verdict == "unexplained"


def warmer(tmp_path: Path, name: str, values: tuple[float, ...], factors: tuple[float, ...]) -> Recording:
    rng = np.random.default_rng(3)
    parts = []
    for value, factor in zip(values, factors, strict=True):
        measured = two_times(T * factor) * (1.0 + 0.003 * rng.standard_normal(T.size))
        head = f"Time,Relaxation Modulus,{name}"
        path = table(tmp_path / f"{value:g}.csv", head, T, measured, np.full(T.size, value))
        parts.append(import_csv(path, is_step=True))
    return join_recordings(parts, "shifted")


def test_the_same_relaxation_shifted_by_temperature_is_named(tmp_path: Path) -> None:
    warm = (20.0, 30.0, 40.0)
    recording = warmer(tmp_path, "temperature", warm, tuple(10 ** (0.08 * (T - 23.0)) for T in warm))
    found = diagnose(recording, threads=1)
    assert found.verdict == "named"
    assert set(found.named) == {"temperature_shift", "second_relaxation"}
    assert found.model.values["s_T"].value == pytest.approx(0.08, rel=0.05)


def test_a_material_that_ages_is_unexplained_over_age(tmp_path: Path) -> None:
    ages = (600.0, 1200.0, 1800.0)
    recording = warmer(tmp_path, "age", ages, tuple(1000.0 / age for age in ages))
    found = diagnose(recording, threads=1)
    assert found.verdict == "unexplained"
    assert found.unexplained is not None
    assert found.unexplained.variable == "age"


def test_a_step_has_no_radius_and_no_zeros_and_is_read_as_it_was_written(tmp_path: Path) -> None:
    recording = step(tmp_path, two_times, KINDS[0])
    write_recording(recording, tmp_path / "step")
    again = read_recording(tmp_path / "step")
    assert again.is_step
    assert {finding.kind for finding in again.report.findings} == {
        Kind.MISSING
    }  # the force of the step itself
    np.testing.assert_array_equal(again.columns["displacement"], recording.columns["displacement"])
    assert set(fit(again).problem.unknowns.names) == {"K", "c1", "nu1"}


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("Time,modulus,compliance", "a modulus or a compliance"),
        ("Time,modulus,normal_force", "no force beside it"),
        ("Time,force,depth", "none of the columns"),
    ],
)
def test_a_table_that_is_no_step_is_refused(tmp_path: Path, head: str, said: str) -> None:
    path = table(tmp_path / "wrong.csv", head, T, two_times(T), T)
    with pytest.raises(RecordingError, match=said):
        import_csv(path, is_step=True)


def test_a_step_and_a_contact_do_not_go_together(tmp_path: Path) -> None:
    contact = import_csv(table(tmp_path / "press.csv", "t,displacement,normal_force", T, 1e-3 * T, T))
    with pytest.raises(RecordingError, match="without a contact"):
        join_recordings([step(tmp_path, two_times, KINDS[0]), contact], "both")


def test_tension_against_length_needs_no_radius(tmp_path: Path) -> None:
    t = np.linspace(0.0, 20.0, 800)
    strain = np.interp(t, [1.0, 3.0], [0.0, 0.2])
    stress = 3e4 * (strain / 0.1) ** 2  # [Pa]
    path = table(tmp_path / "stretch.csv", "s,length,kPa", t, 1.5 + strain, stress / 1e3)
    chart = with_columns(ColumnMap(), ["t=s", "strain=length", "stress=kPa"], ["stress=kPa"])
    strained = dataclasses.replace(chart.channels["strain"], offset=-1.5, noise=1e-5)
    recording = import_csv(path, dataclasses.replace(chart, channels={**chart.channels, "strain": strained}))
    assert recording.is_material
    assert np.isnan(recording.fingertip.radius)
    found = fit(recording).model
    assert found.values["K"].value == pytest.approx(0.03, rel=0.01)  # [MPa] at a strain of a tenth
    assert found.values["p"].value == pytest.approx(2.0, rel=0.01)
