"""A stiffness that changes at one instant or from one depth on: where, and by how much."""

import dataclasses

import numpy as np
import pytest

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.candidate_fit import CandidateFit, evaluate_candidate, held_out_groups
from vegrip.identification.diagnosis.change_point import find_change
from vegrip.identification.diagnosis.discrepancy import find_discrepancy
from vegrip.identification.fit import fit
from vegrip.identification.recording import Recording

SEEDS = range(20)
KINDS = ("hold", "ramp", "hold", "ramp")
FEWEST_HELD = 17  # of 20 intervals of 95 %: fewer by chance are one in 60

pytestmark = pytest.mark.slow


def fitted(recording: Recording) -> CandidateFit:
    found = fit(recording)
    return evaluate_candidate(found.problem, found.optimum, held_out_groups(found.problem))


def test_the_interval_holds_the_instant_of_a_crack_and_its_size_is_known(tip) -> None:
    held, off = 0, []
    for seed in SEEDS:
        rng = np.random.default_rng(100 + seed)
        when, share = rng.uniform(49.0, 51.0), rng.uniform(-0.3, -0.05)  # in the second hold
        found = find_change(fitted(tip(seed, kinds=KINDS, crack=(when, share))))
        assert found.variable == "time"
        assert found.at == pytest.approx(when, abs=0.1)
        held += found.interval[0] <= when <= found.interval[1]
        off.append((found.change - share) / found.std)
    assert held >= FEWEST_HELD
    assert np.mean(np.abs(off) < 2.0) >= 0.8


def test_the_interval_holds_the_depth_of_a_second_object_and_its_stiffness_is_known(tip) -> None:
    held, off = 0, []
    for seed in SEEDS:
        rng = np.random.default_rng(200 + seed)
        depth, stiffness = rng.uniform(0.5, 1.0), rng.uniform(0.8, 2.5)  # [mm], [N/mm]
        found = find_change(fitted(tip(seed, kinds=KINDS, second=(depth, stiffness))))
        assert found.variable == "displacement"
        held += found.interval[0] <= 1e-3 * depth <= found.interval[1]
        off.append((1e-3 * found.change - stiffness) / (1e-3 * found.std))
    assert held >= FEWEST_HELD
    assert np.mean(np.abs(off) < 2.0) >= 0.8


def test_a_slow_drift_has_no_instant(tip) -> None:
    drifting = tip(1, kinds=KINDS)
    drift = 1.0 + 0.2 * np.exp(-drifting.t / 25.0)
    columns = {**drifting.columns, "normal_force": drift * drifting.columns["normal_force"]}
    found = find_discrepancy(fitted(dataclasses.replace(drifting, columns=columns)), with_changes=True)
    assert found.variable == "time"
    assert found.change is None


def test_a_diagnosis_says_when_and_by_how_much(tip) -> None:
    found = diagnose(tip(1, kinds=KINDS, crack=(50.1, -0.18)), most=0)
    told = found.as_dict()
    assert told["verdict"] == "unexplained"
    left = told["unexplained"]
    assert left["variable"] == "time"
    assert left["interval"][0] <= 50.1 <= left["interval"][1] < 50.2
    assert left["at"] == pytest.approx(50.1, abs=0.01)
    assert left["change"] == pytest.approx(-0.18, abs=0.01)
    assert set(left["shape"]) == {"at", "residual", "times"}
    assert "the stiffness falls by 18." in left["note"]
    assert {one["round"] for one in told["rounds"]} == {1}
    assert all(one["outcome"].startswith(("fails: ", "passes, ")) for one in told["rounds"])
