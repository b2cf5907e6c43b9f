"""A pressure profile of its own."""

import numpy as np
import pytest

from vegrip.contact.limit_surface import reference
from vegrip.effects import effect
from vegrip.model import paper_model, predict

T = np.arange(0.0, 2.0, 1e-2)
DEPTH = np.where(T > 0.0, 1e-3, -1e-3)
COUPLED = paper_model(0.01).simulate(T, DEPTH, plain=True).pressure_exponent
MODEL = paper_model(0.01).with_effect(effect("pressure_profile")).with_value("tau_k", 0.4)


def test_exponent_relaxes_to_its_own_in_the_logarithm() -> None:
    model = MODEL.with_value("s_k", 1.0).with_value("k_inf", 5.0)
    k = model.simulate(T, DEPTH, plain=True).pressure_exponent[1:]
    left = np.exp(-T[1:] / 0.4)
    assert k == pytest.approx(COUPLED[1:] ** left * 5.0 ** (1.0 - left))


def test_half_a_share_goes_half_of_the_way() -> None:
    model = MODEL.with_value("s_k", 0.5).with_value("k_inf", 8.0).with_value("tau_k", 1e-3)
    k = model.simulate(T, DEPTH, plain=True).pressure_exponent
    assert k[2:] == pytest.approx(np.sqrt(8.0 * COUPLED[2:]), rel=1e-4)


def test_torque_at_slip_grows_with_the_exponent_as_the_exact_torsion_limit() -> None:
    twist = {"t": T, "displacement": DEPTH, "torque_z": np.full_like(T, 1e-3)}
    model = MODEL.with_value("k_inf", 6.0)
    ratio = (
        predict(model, twist, plain=True)["torque_z"]
        / predict(paper_model(0.01), twist, plain=True)["torque_z"]
    )
    k = predict(model, twist, plain=True)["pressure_exponent"][-1]
    assert ratio[-1] == pytest.approx(
        reference.torsion_limit(k) / reference.torsion_limit(COUPLED[-1]), rel=1e-4
    )
    assert 1.05 < ratio[-1] < 1.14
