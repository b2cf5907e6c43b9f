"""The loop on measured recordings, which are not part of the project: skipped without them (VEGRIP_DATA)."""

import os
from pathlib import Path

import numpy as np
import pytest

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.fit import fit, noise_of
from vegrip.identification.fit.problem import AT
from vegrip.identification.recording import Recording
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.import_csv import import_csv

PROJECT = Path(__file__).parents[3]
DATA = Path(os.environ.get("VEGRIP_DATA", PROJECT.parent / "shared" / "data"))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"no measured recordings in {DATA}"),
]


def read(file: str, chart: str, radius: float) -> Recording:
    return import_csv(DATA / file, read_column_map(PROJECT / f"examples/maps/{chart}.toml"), radius=radius)


@pytest.fixture(scope="module")
def hand() -> Recording:
    """The first five of twenty trials of the robot finger, without the opening between them."""
    whole = read("robot-hand-rh56/middlefinger_hybrid_force250_20trials_20260303-185511.csv", "rh56", 8e-3)
    closing = np.zeros(len(whole), dtype=bool)
    for number in np.unique(whole.episode)[:5]:
        rows = np.flatnonzero(whole.episode == number)
        opened = np.flatnonzero(whole.columns["displacement"][rows] < -0.02)
        closing[rows[opened[-1] :]] = True
    return whole.select(closing)


@pytest.mark.long
def test_one_deep_press_into_silicone_suggests_the_stiffening_and_more_times_of_relaxation_at_no_bound() -> (
    None
):
    """What its README says: the exponent rises with depth, and one relaxation time is not enough.

    A power law and a second time gain the same within 4 nats: one hold does not separate them. And one press
    proves no law of the depth within a tolerance.
    """
    deep = read("silicone-indent/relax_P002-laser-1.csv", "silicone_hold", 40e-3)
    found = diagnose(deep, noise=noise_of(deep).tolerant(0.005))
    assert (found.verdict, found.named) == ("unexplained", [])
    assert "one motion" in found.unproven
    assert "layer_over_core" in {one.candidate.name for one in found.search.accepted}
    assert list(map(set, found.indistinguishable)) == [{"power_law_relaxation", "second_relaxation"}]
    assert found.error["after"] < found.error["noise_floor"] < 0.5 * found.error["before"]
    best = found.search.accepted[-1].fitted
    k, u = best.problem.unknowns, best.optimum.u
    at_a_bound = {
        n for n, low, at, high in zip(k.names, k.low, u, k.high, strict=True) if not low < at < high
    }
    assert at_a_bound.isdisjoint({"K", "p", "c1", "nu1"})


def test_the_slip_in_the_deepest_press_is_told_and_left_out() -> None:
    deep = read("silicone-indent/relax_P002-laser-1.csv", "silicone_hold", 40e-3)
    found = fit(deep, noise=noise_of(deep).tolerant(0.005))
    (event,) = found.problem.measured.events
    assert event.time == pytest.approx(66.4, abs=0.3)
    assert event.loss == pytest.approx(0.34, abs=0.03)
    assert any("no motion explains it" in sentence for sentence in found.warnings())


@pytest.mark.long
def test_an_actuator_that_backs_off_is_not_called_relaxation(hand) -> None:
    noise = noise_of(hand).tolerant(0.02)
    found = fit(hand, noise=noise)
    assert found.model.values["c1"].value < 0.01
    assert any("c1 (relaxation) sits at 0" in sentence for sentence in found.warnings())
    seen = hand.columns["normal_force"]
    said = found.problem.table(found.optimum.u)[:, AT["normal_force"]]
    falls = []
    for number in np.unique(hand.episode):
        rows = np.flatnonzero(hand.episode == number)
        falls.append([1.0 - np.mean(force[rows[-5:]]) / np.max(force[rows]) for force in (seen, said)])
    measured, by_the_motion = np.mean(falls, axis=0)
    assert measured > 0.15
    assert by_the_motion == pytest.approx(measured, abs=0.05)
    told = diagnose(hand, noise=noise)
    assert told.verdict == "unexplained"
    assert "one motion" in told.unproven
    tried = {one.candidate.name for one in told.search.accepted}
    assert not {"second_relaxation", "power_law_relaxation", "nonseparable_relaxation"} & tried
