"""What drives the coupling: one reading keeps both of the paper's cases, the other does not."""

import numpy as np
import pytest

from vegrip.contact.coupling import creep_ratio, largest_force
from vegrip.contact.elastic import PowerStiffness
from vegrip.contact.hereditary import solve
from vegrip.contact.prony import Creep, Relaxation
from vegrip.errors import DomainError

LAW = PowerStiffness(4e4, 0.5)
G = Relaxation([0.3], [3.1])
T = np.linspace(0, 3, 301)


def test_a_step_of_load_gives_the_reduced_creep_compliance() -> None:
    h = Creep([0.3], [3.1])(T)
    delta = LAW.indentation(2.0) * h
    for reference in ("largest", "present"):
        ratio = creep_ratio(T, delta, np.full_like(T, 2.0), LAW, reference=reference)
        assert ratio == pytest.approx(h, rel=1e-13)


def test_a_step_of_displacement_leaves_the_profile_as_it_is() -> None:
    held = solve(T, LAW, G, indentation=np.full_like(T, 1e-3))
    assert creep_ratio(T, held.indentation, held.normal_force, LAW) == pytest.approx(1, abs=1e-13)


def test_with_the_present_force_relaxation_would_flatten_the_profile() -> None:
    held = solve(T, LAW, G, indentation=np.full_like(T, 1e-3))
    ratio = creep_ratio(T, held.indentation, held.normal_force, LAW, reference="present")
    assert ratio == pytest.approx(G(T) ** (-2 / 3), rel=1e-12)


def test_unloading_never_sharpens_the_profile_below_its_start() -> None:
    delta = 1e-3 * np.abs(np.sin(T))
    history = solve(T, LAW, G, indentation=delta)
    assert np.all(creep_ratio(T, history.indentation, history.normal_force, LAW) >= 1)


def test_a_new_contact_starts_anew() -> None:
    N = np.array([0.0, 3.0, 1.0, 0.0, 2.0, 1.0])
    assert largest_force(np.arange(6.0), N).tolist() == [0, 3, 3, 0, 2, 2]


def test_the_largest_force_fades_towards_the_present_one() -> None:
    t = np.array([0.0, 0.5, 1.25, 7.0])
    N = np.array([3.0, 1.0, 1.0, 1.0])
    assert largest_force(t, N, fading=0.8) == pytest.approx(1 + 2 * np.exp(-t / 0.8), rel=1e-13)


def test_without_contact_the_ratio_is_one() -> None:
    assert np.all(creep_ratio([0.0, 1.0], [0.0, 1e-4], [0.0, 0.0], LAW) == 1)


def test_a_pull_is_refused() -> None:
    with pytest.raises(DomainError):
        creep_ratio([0.0, 1.0], [0.0, 1e-4], [0.0, -1.0], LAW)
