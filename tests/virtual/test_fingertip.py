"""One soft fingertip under imposed indentation and imposed force."""

import numpy as np
import pytest

from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.settings import FingertipSettings, random_fingertip

TIP = FingertipSettings(radius=8e-3, reference_force=1.2, amplitudes=(0.3,), rates=(3.1,))
STEP = 1e-3


def press_for(tips: Fingertips, depth: float, duration: float) -> float:
    for _ in range(round(duration / STEP)):
        tips.press(np.array([depth]))
    return float(tips.force[0])


def test_held_indentation_relaxes_to_the_long_time_share() -> None:
    tips = Fingertips([TIP], STEP)
    assert press_for(tips, 1e-3, STEP) == pytest.approx(1.2, rel=1e-3)
    assert press_for(tips, 1e-3, 5.0) == pytest.approx(0.7 * 1.2, rel=1e-6)


@pytest.mark.parametrize(
    ("time", "creep"), [(0.05, 1.029166), (0.2, 1.098223), (0.5, 1.181195), (2.0, 1.265125)]
)
def test_held_force_creeps_as_the_conjugate_compliance(time, creep) -> None:
    """delta/delta_0 = j^(1/p) with the exact conjugate j of g."""
    tips = Fingertips([TIP], STEP)
    for _ in range(round(time / STEP) + 1):
        tips.load(np.array([1.2]))
    assert tips.indentation[0] / 1e-3 == pytest.approx(creep, rel=3e-4)


def test_imposed_force_and_imposed_indentation_are_inverse() -> None:
    rng = np.random.default_rng(1)
    made = [random_fingertip(rng) for _ in range(3)]
    by_force, by_depth = Fingertips(made, STEP), Fingertips(made, STEP)
    for i in range(500):
        wanted = np.array([1.0, 2.0, 0.5]) * (1.0 + 0.5 * np.sin(0.02 * i))
        assert by_depth.press(by_force.load(wanted)) == pytest.approx(wanted, rel=1e-9)


def test_force_never_pulls() -> None:
    tips = Fingertips([TIP], STEP)
    press_for(tips, 2e-3, 2.0)
    for depth in np.linspace(2e-3, -1e-3, 300):
        assert tips.press(np.array([depth]))[0] >= 0.0
    assert tips.force[0] == 0.0


def test_surface_recovers_freely_after_it_has_been_left() -> None:
    """It lags behind the original surface at first, and is back after many relaxation times."""
    tips = Fingertips([TIP], STEP)
    press_for(tips, 2e-3, 2.0)
    press_for(tips, 0.0, 0.05)
    early = float(tips.before[0])
    assert early > 0.0
    press_for(tips, 0.0, 0.5)
    assert 0.0 < tips.before[0] < early
    press_for(tips, 0.0, 5.0)
    assert tips.before[0] == pytest.approx(0.0, abs=1e-3 * early)


def test_second_touch_comes_later_while_the_surface_recovers() -> None:
    tips = Fingertips([TIP], STEP)
    press_for(tips, 2e-3, 2.0)
    press_for(tips, 0.0, 0.05)
    assert press_for(tips, 0.2e-3, STEP) == 0.0
    assert press_for(tips, 2e-3, STEP) > 0.0


def test_contact_radius_is_geometric_and_zero_in_air() -> None:
    tips = Fingertips([TIP], STEP)
    press_for(tips, 1e-3, STEP)
    assert tips.contact_radius[0] == pytest.approx(4e-3, rel=1e-12)
    press_for(tips, -1e-3, STEP)
    assert tips.contact_radius[0] == 0.0


def test_held_indentation_keeps_the_hertz_profile() -> None:
    tips = Fingertips([TIP], STEP)
    press_for(tips, 1e-3, STEP)
    fresh = tips.pressure_exponent[0]
    press_for(tips, 1e-3, 2.0)
    assert fresh == pytest.approx(2.0, abs=0.01)
    assert tips.pressure_exponent[0] == fresh


def test_held_force_flattens_the_profile_as_the_creep_says() -> None:
    tips = Fingertips([TIP], STEP)
    for _ in range(501):
        tips.load(np.array([1.2]))
    # C_k = 1.5 / 1.181195 = 1.269900, between C_2.8 = 1.272006 and C_3 = 1.240490 of Table II
    assert 2.8 < tips.pressure_exponent[0] < 2.83


def test_warm_material_is_softer_and_relaxes_faster() -> None:
    cold, warm = Fingertips([TIP], STEP), Fingertips([TIP], STEP)
    warm.heat(0.9, 2.0)
    assert press_for(warm, 1e-3, STEP) == pytest.approx(0.9 * press_for(cold, 1e-3, STEP), rel=1e-3)
    later = press_for(cold, 1e-3, 0.4), press_for(warm, 1e-3, 0.2)
    assert later[1] == pytest.approx(0.9 * later[0], rel=2e-3)


def test_any_scale_works() -> None:
    """A nanometre tip is the same curve in other units."""
    large = Fingertips([TIP], STEP)
    small = Fingertips(
        [
            FingertipSettings(
                radius=8e-9,
                reference_indentation=1e-9,
                reference_force=1.2e-12,
                amplitudes=(0.3,),
                rates=(3.1,),
            )
        ],
        STEP,
    )
    for depth in np.linspace(0.0, 2e-3, 200):
        assert small.press(np.array([1e-6 * depth])) == pytest.approx(
            1e-12 * large.press(np.array([depth])), rel=1e-9
        )
    assert small.pressure_exponent == pytest.approx(large.pressure_exponent, rel=1e-9)
