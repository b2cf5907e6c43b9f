"""A liquid film between tip and object."""

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict

T = np.arange(0.0, 4.0, 1e-2)
MODEL = paper_model(0.01).with_effect(effect("wet_contact")).with_value("s_w", 0.4).with_value("tau_f", 0.8)


def test_film_is_squeezed_out_exponentially() -> None:
    touched = np.where(T > 0.5, 1e-3, -1e-3)
    age = np.where(T > 0.5, T - 0.5, 0.0)
    mu = MODEL.simulate(T, touched, plain=True).friction_coefficient
    assert mu == pytest.approx(0.7 * (1.0 - 0.4 * np.exp(-age / 0.8)), rel=1e-12)


def test_film_comes_back_in_air() -> None:
    depth = np.where((T > 2.0) & (T < 2.1), -1e-3, 1e-3)
    mu = MODEL.simulate(T, depth, plain=True).friction_coefficient
    assert mu[np.argmin(np.abs(T - 2.05))] == pytest.approx(0.7 * 0.6)


def test_limits_in_force_and_torque_rise_alike_with_the_dwell() -> None:
    columns = {
        "t": T, "displacement": np.full_like(T, 1e-3), "tangential_force_x": np.full_like(T, 0.3),
        "torque_z": np.full_like(T, 1e-3),
    }  # fmt: skip
    wet, dry = predict(MODEL, columns, plain=True), predict(paper_model(0.01), columns, plain=True)
    for channel in ("tangential_force", "torque_z", "limit_force", "limit_torque"):
        assert wet[channel] / dry[channel] == pytest.approx(1.0 - 0.4 * np.exp(-T / 0.8))
