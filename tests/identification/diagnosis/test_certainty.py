"""How sure a verdict is: as often as a new recording would lead to the same."""

import json

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.certainty import Redrawn, certainty_of, certify, chance_of
from vegrip.identification.recording import write_recording

KINDS = ("hold", "ramp", "hold", "ramp", "hold", "ramp")
pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("pull", "answer", "least", "most"),
    [(0.0, "adequate", 19, 20), (0.03, "named: adhesion", 19, 20), (0.006, "named: adhesion", 2, 18)],
)
def test_what_is_plain_is_the_same_in_all_draws_and_what_is_at_the_limit_in_some(
    tip, pull, answer, least, most
) -> None:
    found = certainty_of(diagnose(tip(13, kinds=KINDS, pull=pull)))
    assert least <= found.answers.get(answer, 0) <= most
    assert sum(found.answers.values()) == found.draws == 20
    assert next(iter(found.answers.values())) == found.same


def test_with_even_weights_the_evidence_is_that_of_the_fit(tip) -> None:
    found = diagnose(tip(12, kinds=KINDS, pull=0.03))
    last = found.search.last
    redrawn, even = Redrawn(last, found.groups), np.ones(np.unique(found.groups).size)
    assert redrawn.evidence(even) == pytest.approx(last.evidence, abs=0.05)
    misfit, error = redrawn.left(even, found.search.regimes)
    assert (misfit, error) == pytest.approx((found.search.misfit(last), last.error), rel=1e-3)


def test_the_command_says_it_when_asked(tip, tmp_path, capsys) -> None:
    write_recording(tip(12, kinds=KINDS, pull=0.03), tmp_path / "tip")
    assert main(["diagnose", str(tmp_path / "tip"), "--draws", "10", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["certainty"]
    assert (told["draws"], told["same"]) == (10, 10)


@pytest.mark.parametrize(("seed", "pull"), [(13, 0.03), (12, 0.012)])
def test_an_effect_is_certified_by_episodes_that_did_not_tell_its_values(tip, seed, pull) -> None:
    assert certify(diagnose(tip(seed, kinds=KINDS, pull=pull)))["adhesion"] < 1e-6


def test_the_certificate_has_exact_size_without_an_effect() -> None:
    rng = np.random.default_rng(4)
    J, s, draws = rng.normal(size=(30, 3)), rng.normal(size=30), 2000
    chances = np.array([chance_of(s, 1.7 * rng.standard_normal(30), J) for _ in range(draws)])
    for level in (0.01, 0.05, 0.5):
        assert np.mean(chances < level) == pytest.approx(level, abs=3.0 * np.sqrt(level / draws))
