"""What the fingers of a grasp share has one place for every number, the same by its name and in the array."""

import ast

import numpy as np

from vegrip.grip.grasp_memory import PLACES, SIZE, GraspMemory, constants


def test_what_is_written_by_name_stands_at_the_place_that_the_step_reads() -> None:
    g = GraspMemory()
    for section, name, _, length in PLACES:
        numbers = getattr(g, section)
        if not length:
            setattr(numbers, name, 1.0)
        for i in range(length):
            getattr(numbers, name)[i] += float(i + 1)
    for assigned in ast.parse(constants()).body[2:]:
        assert isinstance(assigned, ast.Assign)
        assert g.array[ast.literal_eval(assigned.value)] == 1.0, ast.unparse(assigned.targets[0])
    lengths = [length or 1 for *_, length in PLACES]
    assert g.array[-sum(lengths) :].tolist() == [float(i + 1) for length in lengths for i in range(length)]
    assert len(g.array) == SIZE


def test_the_first_numbers_are_the_needs_of_the_fingers() -> None:
    g = GraspMemory(3)
    assert np.isnan(g.array[:3]).all()
    assert not g.array[3:].any()
    g[1] = 2.5
    assert (g.array[1], g[1]) == (2.5, 2.5)
