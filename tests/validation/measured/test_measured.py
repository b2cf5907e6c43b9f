"""The table of measured recordings: what was found foretells what no fit has seen."""

import math

import pytest

from validation.measured.__main__ import HEAD, WAYS, judge, row
from validation.measured.cases import CASES, FURTHER, data_folder

KNOWN = {case.name: case for case in (*CASES, *FURTHER)}


@pytest.mark.long
@pytest.mark.skipif(not data_folder().is_dir(), reason="the measured recordings are no part of the project")
def test_a_ramp_of_the_muscle_that_was_held_out_is_foretold_within_a_tenth_of_its_peak() -> None:
    case = KNOWN["muscle"]
    found = judge(case, data_folder())
    assert set(found.heldout) == set(WAYS)
    assert all(math.isfinite(one) for one in found.heldout.values())
    assert found.heldout["found"] < min(0.1, found.heldout["paper"])
    assert row(case, found).count("|") == HEAD[0].count("|")


def test_each_case_says_where_it_is_from_and_what_is_known_of_it() -> None:
    for case in KNOWN.values():
        assert all((case.source, case.licence, case.known)), case.name
        if {*case.train} & {*case.heldout}:  # other rows or episodes of the same file
            assert (case.rows[0], case.episodes[0]) != (case.rows[1], case.episodes[1])
