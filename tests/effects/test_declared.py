"""What the search for a missing effect and the estimator are told of each effect, beside the page of effects.

Only what differs from the rule, which is written out first.
"""

import pytest

from vegrip.effects import BUILT_IN, effect

RULE = {
    "channels": ("normal_force",), "group": "", "kinked": False, "expensive": False, "shifts_time": False,
    "in_air": False, "companions": (), "min_gain": 0.0, "min_amounts": (), "min_displacement_noises": (),
    "beyond_simpler": (0, ()), "trial_sizes": (1.0,), "trial_shapes": (), "generalises": (),
}  # fmt: skip
FRICTION = {"channels": ("tangential_force", "torque_z")}
LATE = {"shifts_time": True, "trial_sizes": (1.0, 10.0)}
ASIDE = {"channels": ("normal_force", "tangential_force")}
SEARCHED = {
    "displacement_lag": {**LATE, "companions": ("fast_damping",), "min_amounts": (("tau_d", 3e-4),)},
    "displacement_backlash": {
        "kinked": True, "min_displacement_noises": (("play", 3.0),), "trial_sizes": (0.2, 1.0, 4.0),
    },
    "inclination": ASIDE,
    "series_compliance": {"channels": ("normal_force", "contact_radius"), "expensive": True},
    "mullins_softening": {"companions": ("healing_softening",)},
    "healing_softening": {
        "companions": ("mullins_softening",), "beyond_simpler": (1, (("nu_h", 4e-4),)),
        "trial_shapes": (("w_h", (0.6,)), ("nu_h", (3e-3, 0.03, 0.3))),
    },
    "second_relaxation": {
        "companions": ("power_law_relaxation",),
        "trial_shapes": (("nu2", (0.02, 0.06, 0.2, 0.6, 2.0, 8.0, 40.0)),),
    },
    "power_law_relaxation": {"expensive": True, "companions": ("second_relaxation",)},
    "relaxation_spectrum": {
        "generalises": ("second_relaxation", "power_law_relaxation"), "expensive": True,
        "trial_shapes": (("nu_s", (0.01,)),),
    },
    "fast_damping": {"shifts_time": True, "companions": ("displacement_lag",)},
    "layer_over_core": {"trial_shapes": (("x_c", (0.75, 1.5)),)},
    "second_contact": {"trial_shapes": (("x_2", (1.2,)),)},
    "adhesion": {"kinked": True, "companions": ("jkr_adhesion",)},
    "jkr_adhesion": {"kinked": True, "in_air": True, "companions": ("adhesion",)},
    "inertia": {"shifts_time": True, "min_gain": 20.0},
    "rolling": ASIDE,
    "guide_friction": {"in_air": True},
    "approach_tilt": {"in_air": True},
    "sensor_lag": {
        **LATE, "group": "timing", "companions": ("sensor_delay",), "min_amounts": (("tau", 3e-4),),
    },
    "sensor_delay": {
        **LATE, "group": "timing", "companions": ("sensor_lag",), "min_amounts": (("T_y", 3e-4),),
    },
    "saturation": {"kinked": True},
    "contact_radius_law": {"channels": ("contact_radius", "torque_z")},
    "pressure_profile": {"channels": ("torque_z",)},
    "load_dependent_friction": FRICTION, "rate_dependent_friction": FRICTION, "friction_ageing": FRICTION,
    "wet_contact": FRICTION, "presliding": {"channels": ("tangential_force",)},
}  # fmt: skip

LEARNED = {
    "K": 1e-3,
    "p": 0.0,
    "c1": 3e-4,
    "nu1": 0.0,
    "c2": 3e-4,
    "nu2": 0.0,
    "mu": 0.0,
}  # drift [1/sqrt(s)]
EXTREMES = {"delta_max", "x_max", "x_h", "sticking", "joined", "largest_force"}
LASTING = {"x_p", "delta_max", "d_c", "x_max", "x_h", "b_F"}


@pytest.mark.parametrize("name", BUILT_IN)
def test_an_effect_is_searched_for_as_the_rule_says_but_for_what_is_written_here(name: str) -> None:
    assert {field: getattr(effect(name), field) for field in RULE} == {**RULE, **SEARCHED.get(name, {})}


def test_the_estimator_learns_the_stiffness_two_relaxations_and_friction() -> None:
    parameters = [one for name in BUILT_IN for one in effect(name).parameters]
    assert {one.symbol: one.drift for one in parameters if one.learn} == LEARNED
    assert all(one.drift == 0.0 for one in parameters if not one.learn)


def test_states_begin_at_zero_and_recover_but_for_those_written_here() -> None:
    states = [one for name in BUILT_IN for one in effect(name).states]
    assert {one.name: one.initial for one in states if one.initial} == {"film": 1.0}
    assert {one.name for one in states if one.extreme} == EXTREMES
    assert {one.name for one in states if one.lasting} == LASTING


def test_saturation_is_tried_below_the_greatest_force_that_was_measured() -> None:
    trials_at = effect("saturation").trials_at
    assert trials_at is not None
    assert [one["s_F"] for one in trials_at({"K": 2.0}, 8.0)] == pytest.approx([2.0 / 7.84, 2.0 / 7.2])
    assert [one["s_F"] for one in trials_at({"K": 2.0}, 1e-6)] == [1e3, 1e3]  # its bound
    assert list(trials_at({}, 8.0)) == []
    tried = {name for name in BUILT_IN if effect(name).trials_at}
    assert tried == {"layer_over_core", "second_contact", "saturation"}


@pytest.mark.parametrize(
    ("name", "symbol", "depths"),
    [("layer_over_core", "x_c", [2.0, 3.0, 1.2, 2.2, 3.2]), ("second_contact", "x_2", [1.2, 2.2, 3.2])],
)
def test_what_is_touched_at_a_depth_is_tried_within_that_of_the_greatest_force(name, symbol, depths) -> None:
    trials_at = effect(name).trials_at
    assert trials_at is not None
    tried = list(trials_at({"K": 2.0, "p": 1.5}, 16.0))  # 4 x_ref
    assert [one[symbol] for one in tried] == pytest.approx(depths)
    assert all({*one} == {p.symbol for p in effect(name).parameters} for one in tried)
    assert list(trials_at({}, 8.0)) == []
