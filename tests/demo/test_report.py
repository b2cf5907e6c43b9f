"""What is said at the end fits what happened, whoever did better."""

import pytest

from vegrip.demo.others import AS_FORCEFUL
from vegrip.demo.report import compare_results, describe_scenario, judge_machine
from vegrip.validation.controllers.result import Result
from vegrip.validation.controllers.scenario import GRASPS, Scenario, fitting_grasp

OURS = Result(slips=0, dropped=False, mean_grip_force=4.0, peak_grip_force=9.0, min_margin=0.2)


def test_a_controller_that_takes_more_force_is_said_to() -> None:
    theirs = Result(0, False, 8.0, 15.0, 0.3)
    assert compare_results({"vegrip": OURS, "cone": theirs}) == [
        "Coulomb cone: 2.0 times the force of vegrip, 0 slips against 0, least margin 0.30 against 0.20"
    ]


def test_a_controller_that_takes_less_force_is_said_to_as_well() -> None:
    theirs = Result(0, False, 3.0, 15.0, 0.1)
    (sentence,) = compare_results({"vegrip": OURS, "cone": theirs})
    assert sentence.startswith("Coulomb cone: 25 % less force than vegrip")


def test_a_controller_with_about_the_same_force_is_said_to_have_it() -> None:
    theirs = Result(2, False, 4.1, 15.0, 0.0)
    assert compare_results({"vegrip": OURS, "cone" + AS_FORCEFUL: theirs}) == [
        "Coulomb cone, same force: as much force as vegrip, 2 slips against 0, least margin 0.00 against 0.20"
    ]


def test_who_dropped_the_object_is_named_also_when_it_was_vegrip() -> None:
    lost = Result(3, True, 2.0, 15.0, 0.0)
    assert compare_results({"vegrip": OURS, "cone": lost}) == [
        "Coulomb cone against vegrip: Coulomb cone dropped the object"
    ]
    assert "vegrip dropped the object" in compare_results({"vegrip": lost, "cone": OURS})[0]


@pytest.mark.parametrize(
    ("held", "late", "words"),
    [(0.3, 0.5, "too busy: 30 %"), (0.02, 0.0, "too busy: 2 %"), (0.001, 0.12, "the figures stand")],
)
def test_a_busy_machine_is_judged_by_what_it_did_to_the_commands(
    held: float, late: float, words: str
) -> None:
    (sentence,) = judge_machine(held, late)
    assert words in sentence


def test_a_machine_in_time_is_not_mentioned() -> None:
    assert judge_machine(0.002, 0.004) == []


@pytest.mark.parametrize(
    ("cores", "grasp"), [(1, "pinch"), (2, "pinch"), (3, "pinch"), (4, "hand"), (64, "hand")]
)
def test_few_cores_get_the_grasp_that_they_can_show(cores: int, grasp: str) -> None:
    assert fitting_grasp(cores) == grasp


@pytest.mark.parametrize("grasp", GRASPS)
def test_what_to_see_names_the_grasp_and_what_to_look_at(grasp: str) -> None:
    told = describe_scenario(Scenario(0, 30.0, grasp))
    assert ("thumb and index pinch" if grasp == "pinch" else "5 fingers hold") in told
    assert "Look at F, the grip force" in told
    assert max(map(len, told.splitlines())) <= 120
