"""Effects of other packages that have a name in common with one that is built in."""

import pytest

from vegrip.effects import effect
from vegrip.effects.contract import Effect, State, hook
from vegrip.identification.diagnosis.score_tests import Candidate, candidates, carrier, null
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.model import paper_model
from vegrip.parameters import Parameter


def force(force: float, x: float, pull_back: float, x_p: float) -> tuple[float, float]:
    """Return the force, and the depth, whose name the play has for its own."""
    return force + pull_back * (x - x_p), x


MINE = Effect(
    name="mine",
    summary="drag",
    cites=("own",),
    parameters=(Parameter("pull_back", "N/m", 1.0, 1.0, -10.0, 10.0, "drag", null=0.0),),
    states=(State("x_p", "m", "depth before"),),
    hooks=(hook(force),),
)


@pytest.fixture
def mine() -> Candidate:
    return Candidate(MINE, null(MINE), ())


def test_the_screen_runs_it_beside_all_others_that_go_with_it(mine) -> None:
    names = {one.name for one in carrier(paper_model(8e-3), [mine]).effects}
    assert "mine" in names
    assert "displacement_backlash" not in names
    assert "adhesion" in names
    assert "displacement_backlash" in {one.name for one in carrier(paper_model(8e-3), []).effects}


def test_what_does_not_go_with_a_model_is_told_and_not_tried(bench) -> None:
    recording = bench()
    possible, out_of_sight = candidates(
        paper_model(8e-3).with_effect(MINE), preprocess(recording, noise_of(recording))
    )
    assert "displacement_backlash" not in {one.name for one in possible}
    assert "mine and displacement_backlash both have 'x_p'" in out_of_sight["displacement_backlash"] or (
        "displacement_backlash and mine both have 'x_p'" in out_of_sight["displacement_backlash"]
    )
    assert effect("adhesion").name in {one.name for one in possible}
