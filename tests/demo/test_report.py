"""What is said at the end fits what happened, whoever did better."""

import pytest

from vegrip.demo.report import (
    AS_FORCEFUL,
    AS_SURE,
    TOO_SHORT,
    compare_courses,
    describe_scenario,
    judge_machine,
    until_drops,
)
from vegrip.trials.closed_loop import GRASPS, Course, Scenario, fitting_grasp


def course(force: float, slips: int = 0, ends: float = 30.0, *, dropped: bool = False) -> Course:
    """Return a run with one force from beginning to end."""
    times = [1.0, 0.5 * ends, ends]
    return Course(("thumb",), slips, dropped, times, [[0.2]] * 3, [[force]] * 3)


OURS = course(4.0)


def test_the_force_of_a_tuned_controller_is_compared_and_whether_it_slipped_as_often() -> None:
    told = compare_courses({"vegrip": OURS, "constant": course(8.0), "cone": course(3.0, slips=2)})
    assert told == [
        "constant grip: 2.0 times the force of vegrip, as many slips (0)",
        "Coulomb cone: 25 % less force than vegrip, 2 slips against 0",
    ]


def test_who_dropped_the_object_is_named_also_when_it_was_vegrip() -> None:
    lost = course(2.0, 3, 10.0, dropped=True)
    assert compare_courses({"vegrip": OURS, "cone": lost}) == [
        "Coulomb cone against vegrip: Coulomb cone dropped the object"
    ]
    assert "vegrip dropped the object" in compare_courses({"vegrip": lost, "cone": OURS})[0]


def test_with_the_same_force_slips_and_drops_are_compared() -> None:
    lost = course(4.02, 3, 10.0, dropped=True)
    assert compare_courses({"vegrip": OURS, "cone" + AS_FORCEFUL: lost}) == [
        "Coulomb cone, same force: 3 slips and the object dropped after 10.0 s; vegrip: 0 slips"
    ]
    assert compare_courses({"vegrip": course(4.0, 1), "constant" + AS_FORCEFUL: course(3.9, 1)}) == [
        "constant, same force (3.90 N against 4.00 N): 1 slip; vegrip: 1 slip"
    ]


def test_the_force_of_as_few_slips_is_compared_and_said_to_be_found_afterwards() -> None:
    ours, least = course(4.0, 1), course(6.0, 1)
    told = compare_courses({"vegrip": ours, "cone" + AS_FORCEFUL: course(4.0, 5), "cone" + AS_SURE: least})
    assert told == [
        "Coulomb cone, same force: 5 slips; vegrip: 1 slip",
        "Coulomb cone, same slips: 6.00 N against 4.00 N, with the constant that this run itself asks for",
    ]


def test_the_mean_until_a_drop_stands_beside_that_of_vegrip_until_then() -> None:
    ours = Course(("thumb",), 0, False, [1.0, 10.0, 30.0], [[0.2]] * 3, [[3.0], [3.2], [9.0]])
    cone, constant = (course(3.1, 1, end, dropped=True) for end in (10.0, 9.98))
    told = until_drops({"vegrip": ours, "cone": cone, "constant": constant})
    assert told == "means end where the object is dropped; vegrip: 3.10 N until 10.0 s"
    assert until_drops({"vegrip": ours, "cone": course(8.0)}) is None


def test_a_run_in_which_nothing_slipped_with_the_same_force_is_called_too_short() -> None:
    alike = {name + AS_FORCEFUL: course(4.0) for name in ("constant", "cone")}
    assert compare_courses({"vegrip": OURS, **alike}) == [TOO_SHORT]


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
def test_what_to_see_names_the_grasp_and_what_to_look_at_where_it_is_shown(grasp: str) -> None:
    assert "Look at" not in describe_scenario(Scenario(0, 30.0, grasp), shown=False)
    told = describe_scenario(Scenario(0, 30.0, grasp), shown=True)
    assert ("thumb and index pinch" if grasp == "pinch" else "5 fingers hold") in told
    assert "Look at F, the grip force" in told
    assert max(map(len, told.splitlines())) <= 120
