"""Contact radius law."""

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict

R = 0.01
T = np.arange(0.0, 0.5, 5e-3)
DEPTH = 1e-3 * np.clip(5.0 * T, 1e-3, 1.0)
MODEL = paper_model(R).with_effect(effect("contact_radius_law"))


def test_radius_is_that_of_the_law_at_every_depth() -> None:
    model = MODEL.with_value("kappa", 1.3).with_value("chi", 0.4)
    radius = model.simulate(T, DEPTH, plain=True).contact_radius
    assert radius == pytest.approx(np.sqrt(1.3 * R * DEPTH - 0.4 * DEPTH**2), rel=1e-12)


def test_hertz_and_the_exact_cut_of_a_sphere_are_special_cases() -> None:
    hertz = MODEL.with_value("kappa", 1.0).simulate(T, DEPTH, plain=True).contact_radius
    assert hertz == pytest.approx(np.sqrt(R * DEPTH))
    cut = MODEL.with_value("kappa", 2.0).with_value("chi", 1.0).simulate(T, DEPTH, plain=True).contact_radius
    assert cut**2 + (R - DEPTH) ** 2 == pytest.approx(np.full_like(T, R**2))


def test_torque_at_slip_grows_by_the_root_of_half_of_kappa_and_the_force_at_slip_not_at_all() -> None:
    twist = {"t": T, "displacement": DEPTH, "torque_z": np.full_like(T, 1e-3)}
    pull = {"t": T, "displacement": DEPTH, "tangential_force_x": np.full_like(T, 0.2)}
    base, model = paper_model(R), MODEL.with_value("kappa", 1.2)
    ratio = predict(model, twist, plain=True)["torque_z"] / predict(base, twist, plain=True)["torque_z"]
    assert ratio == pytest.approx(np.full_like(T, np.sqrt(1.2 / 2.0)))
    ratio = (
        predict(model, pull, plain=True)["tangential_force"]
        / predict(base, pull, plain=True)["tangential_force"]
    )
    assert ratio == pytest.approx(np.ones_like(T))
