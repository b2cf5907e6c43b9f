"""The table of measured recordings: what was found foretells what no fit has seen."""

import math
from pathlib import Path

import numpy as np
import pytest

from validation.measured.__main__ import HEAD, WAYS, judge, read, row
from validation.measured.cases import CASES, FURTHER, Case, data_folder

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


def test_a_step_of_which_part_is_fitted_and_part_is_held_out_begins_at_one_instant(tmp_path: Path) -> None:
    t = np.geomspace(0.1, 99.0, 200)
    rows = "\n".join(f"{at:.6f}\t{2e5 * at**-0.1:.6f}" for at in t)
    (tmp_path / "clay_1800.csv").write_text(f"Time\tRelaxation Modulus\n{rows}\n", encoding="utf-8")
    case = Case(
        "clay", "clay", "", ("clay_1800.csv",), ("clay_1800.csv",),
        rows=(r"^Time|^\d\.", r"^Time|^\d\d\."), beside=("age", r"_(\d+)"),
    )  # fmt: skip
    early, late = (read(case, tmp_path, which) for which in (0, 1))
    np.testing.assert_allclose(np.r_[early.t[2:], late.t[2:]], t, atol=2e-5)
    for one in (early, late):
        assert one.is_step
        assert np.unique(one.columns["age"]).tolist() == [1800.0]
        assert one.columns["displacement"][2] == one.columns["displacement"][-1] > 0.0
