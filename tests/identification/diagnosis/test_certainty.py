"""How sure a verdict is: as often as a new recording would lead to the same."""

import functools
import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import t as student

from vegrip.cli import main
from vegrip.effects import effect
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.acceptance import Verdict
from vegrip.identification.diagnosis.certainty import (
    Certainty,
    Redraw,
    Redrawn,
    certainty_of,
    certify,
    chance_of,
)
from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.diagnosis.search import Search, Step, Tried
from vegrip.identification.recording import write_recording

KINDS = ("hold", "ramp", "hold", "ramp", "hold", "ramp")


@pytest.fixture(scope="module")
def sticky(tip):
    """Give the diagnosis of a tip that sticks, by seed and pull."""
    return functools.cache(lambda seed, pull: diagnose(tip(seed, kinds=KINDS, pull=pull)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pull", "answer", "least", "most"),
    [(0.0, "adequate", 19, 20), (0.006, "adequate", 2, 18)],
)
def test_what_is_plain_is_the_same_in_all_draws_and_what_is_at_the_limit_in_some(
    sticky, pull, answer, least, most
) -> None:
    found = certainty_of(sticky(13, pull))
    assert least <= found.answers.get(answer, 0) <= most
    assert sum(found.answers.values()) == found.draws == 20
    assert next(iter(found.answers.values())) == found.same


@pytest.mark.slow
def test_with_even_weights_the_evidence_is_that_of_the_fit(sticky) -> None:
    found = sticky(12, 0.012)
    last = found.search.last
    redrawn, even = Redrawn(last, found.groups), np.ones(np.unique(found.groups).size)
    assert redrawn.evidence(even) == pytest.approx(last.evidence, abs=0.05)
    misfit, error = redrawn.left(even, found.search.regimes)
    assert (misfit, error) == pytest.approx((found.search.misfit(last), last.error), rel=1e-3)


@pytest.mark.long
def test_the_command_says_it_when_asked(tip, tmp_path, capsys) -> None:
    write_recording(tip(12, kinds=KINDS, pull=0.03), tmp_path / "tip")
    assert main(["diagnose", str(tmp_path / "tip"), "--draws", "10", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["named"] == ["adhesion"]  # which is plain, so all draws say the same
    assert (told["certainty"]["draws"], told["certainty"]["same"]) == (10, 10)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "pull"), [pytest.param(13, 0.03, marks=pytest.mark.long), (12, 0.012)])
def test_an_effect_is_certified_by_episodes_that_did_not_tell_its_values(sticky, seed, pull) -> None:
    assert certainty_of(sticky(seed, pull), draws=1).certified["adhesion"] < 1e-6


def test_the_certificate_has_exact_size_without_an_effect() -> None:
    rng = np.random.default_rng(4)
    J, s, draws = rng.normal(size=(30, 3)), rng.normal(size=30), 2000
    chances = np.array([chance_of(s, 1.7 * rng.standard_normal(30), J) for _ in range(draws)])
    for level in (0.01, 0.05, 0.5):
        assert np.mean(chances < level) == pytest.approx(level, abs=3.0 * np.sqrt(level / draws))


GROUPS = np.repeat(np.arange(8.0), 20)
X = np.random.default_rng(3).normal(size=(160, 3))
STD = np.array([0.7, 2.0, 3.0])
NOISE = np.random.default_rng(9).standard_normal(160)


def test_a_group_of_weight_two_counts_as_if_it_were_there_twice(linear) -> None:
    rng, middle = np.random.default_rng(6), np.array([0.2, -0.3])
    y = X[:, :2] @ [0.5, 1.0] + rng.standard_normal(160)
    weights = np.array([0.0, 1.0, 2.0, 3.0, 1.0, 0.0, 2.0, 1.0])
    rows = np.repeat(np.arange(160), weights[GROUPS.astype(int)].astype(int))
    scale = rng.uniform(0.1, 0.2, 160)
    one, more = linear(y, X[:, :2], STD[:2], middle), linear(y[rows], X[rows, :2], STD[:2], middle)
    one.whitener.log_scale[:], more.whitener.log_scale[:] = scale, scale[rows]
    redrawn, drawn = Redrawn(one.fitted(GROUPS), GROUPS), more.fitted(GROUPS[rows])
    assert redrawn.evidence(weights) == pytest.approx(drawn.evidence, rel=1e-12)
    regimes = np.tile(np.arange(4.0), 40)
    misfit, error = redrawn.left(weights, regimes)
    assert error == pytest.approx(drawn.error, rel=1e-12)
    w, each = y - X[:, :2] @ drawn.optimum.u, weights[GROUPS.astype(int)]
    told = [
        np.sum((each * w)[at]) ** 2 / np.sum(each[at] ** 2) for at in (regimes == i for i in np.arange(4.0))
    ]
    assert misfit == pytest.approx(np.mean(told), rel=1e-12)


def ordinary(s, r, J) -> float:
    """Return the one-sided p of the last coefficient of an ordinary least-squares fit."""
    A = np.column_stack([J, s])
    beta, *_ = np.linalg.lstsq(A, r, rcond=None)
    free = r.size - A.shape[1]
    std = np.sqrt(np.sum((r - A @ beta) ** 2) / free * np.linalg.inv(A.T @ A)[-1, -1])
    return float(student.sf(beta[-1] / std, free))


@pytest.mark.parametrize("size", [-0.3, 0.0, 0.2, 1.0])
def test_the_chance_is_that_of_a_coefficient_of_ordinary_least_squares(size) -> None:
    r = size * X[:20, 2] + np.random.default_rng(1).standard_normal(20)
    assert chance_of(X[:20, 2], r, X[:20, :2]) == pytest.approx(ordinary(X[:20, 2], r, X[:20, :2]), rel=1e-9)
    assert chance_of(X[:4, 2], r[:4], X[:4, :2]) == pytest.approx(ordinary(X[:4, 2], r[:4], X[:4, :2]))
    assert chance_of(X[:3, 2], r[:3], X[:3, :2]) == 1.0  # no freedom
    assert chance_of(np.zeros(20), r, X[:20, :2]) == 1.0


def diagnosed(linear, where, amount=1.0, rival=None, noise=NOISE, column=X[:, 2]) -> Diagnosis:
    """Return a diagnosis that has named adhesion, which is there in some groups, and perhaps a rival."""
    y = amount * column * np.isin(GROUPS, where) + noise
    base = linear(y, X[:, :2], STD[:2]).fitted(GROUPS)
    new = linear(y, np.column_stack([X[:, :2], column]), STD).fitted(GROUPS)

    def tried(name, fitted, failed=()):
        verdict = Verdict(fitted.evidence - base.evidence, 1.0, failed)
        return Tried(SimpleNamespace(name=name, effect=effect(name)), fitted, verdict, np.zeros(1))

    own = tried("adhesion", new)
    rest = [] if rival is None else [tried("sensor_lag", rival(y), ())]
    contest = Step(base, [], [own, *rest], own)
    search = Search([contest, Step(new, [], [])], regimes=np.zeros(160), contests={"adhesion": contest})
    found = Diagnosis(SimpleNamespace(problem=SimpleNamespace(episodes=np.zeros(1))), search)
    vars(found).update(_rest=None, groups=GROUPS)
    return found


def test_what_some_episodes_have_is_named_in_draws_of_these(linear) -> None:
    redraw = Redraw(diagnosed(linear, [0, 1, 2, 3]), GROUPS)
    assert redraw.count == 8
    assert redraw.answer(np.ones(8)) == "named: adhesion"
    assert redraw.answer(np.array([2.0] * 4 + [0.0] * 4)) == "named: adhesion"
    assert redraw.answer(np.array([0.0] * 4 + [2.0] * 4)) == "adequate"


def test_two_that_gain_as_much_in_a_draw_are_one_or_the_other(linear) -> None:
    found = diagnosed(linear, range(8), rival=lambda y: linear(y, X, STD).fitted(GROUPS))
    assert Redraw(found, GROUPS).answer(np.ones(8)) == "ambiguous: adhesion or sensor_lag"
    other = X + np.random.default_rng(2).normal(size=X.shape) * [0.0, 0.0, 1.0]
    found = diagnosed(linear, range(8), rival=lambda y: linear(y, other, STD).fitted(GROUPS))
    assert Redraw(found, GROUPS).answer(np.ones(8)) == "named: adhesion"


def test_what_lacked_evidence_alone_is_named_where_a_draw_has_it(linear) -> None:
    found = diagnosed(linear, range(8), 0.3)
    last = found.search.steps[-1]
    last.base = found.search.first
    last.tried = [found.search.steps[0].tried[0]]
    found.search.steps, found.search.contests = [last], {}
    for failed, answer in (("evidence",), "named: adhesion"), (("evidence", "error"), "adequate"):
        object.__setattr__(last.tried[0].verdict, "failed", failed)
        assert Redraw(found, GROUPS).answer(np.ones(8)) == answer
    object.__setattr__(last.tried[0], "fitted", last.base)
    assert Redraw(found, GROUPS).answer(np.ones(8)) == "adequate"


def test_draws_are_counted_the_given_answer_first_and_said_in_a_sentence(linear) -> None:
    told = certainty_of(diagnosed(linear, range(8)), draws=7)
    assert (told.draws, told.same, dict(told.answers)) == (7, 7, {"named: adhesion": 7})
    assert told.certified["adhesion"] < 1e-6
    some = certainty_of(diagnosed(linear, range(8), 0.3), draws=30)
    assert next(iter(some.answers)) == "named: adhesion"
    assert 15 < some.same == some.answers["named: adhesion"] < 28
    assert sum(some.answers.values()) == 30
    told = Certainty(20, 15, {"named: a": 15, "adequate": 4, "unexplained": 1}, {"a": 0.0021, "b": 0.5})
    drawn = "the same answer in 15 of 20 draws (adequate in 4, unexplained in 1)"
    assert told.note == f"{drawn}; on episodes held apart a p = 0.002, b p = 0.5"
    assert Certainty(20, 20, {"adequate": 20}, {}).note == "the same answer in 20 of 20 draws"
    assert Certainty(0, 0, {"named: a": 0}, {"a": 0.0021}).note == "on episodes held apart a p = 0.002"
    assert not Certainty(0, 0, {"adequate": 0}, {}).note


@pytest.mark.parametrize("looks", [0, 1, 3, 10**6])
def test_a_certificate_is_the_worse_of_two_tests_each_on_episodes_that_told_no_values(linear, looks) -> None:
    """Episodes 0, 3, 5, 6 and the others: whichever kinds alternate, both halves have all.

    Times the number of candidates, among which the name was chosen.
    """
    found = diagnosed(linear, [0, 1, 4, 7], 0.6)
    found.search.steps[0].hints = range(looks)  # of which the number counts
    base, new = found.search.first.problem, found.search.contests["adhesion"].tried[0].fitted.problem
    expected = []
    for part in ([0, 3, 5, 6], [1, 2, 4, 7]):
        rows = np.isin(GROUPS, part)
        kept = np.where(rows, 1e-3, 1.0)
        left = [
            one.table(linear(kept * one.y, kept[:, None] * one.columns, one.unknowns.std).solved().u)
            for one in (base, new)
        ]
        r, J = base.table(base.solved().u), base.columns
        expected.append(ordinary((left[0] - left[1])[rows], r[rows], J[rows]))
    assert min(expected) < 0.5 * max(expected)
    assert certify(found)["adhesion"] == pytest.approx(min(max(looks, 1) * max(expected), 1.0), rel=0.01)


@pytest.mark.long
def test_among_many_candidates_noise_is_certified_no_more_often_than_it_is_allowed(linear) -> None:
    """Whichever of ten is chosen, and by all rows: the least chance of ten keeps its level."""
    rng = np.random.default_rng(8)
    draws, least = 150, []
    for _ in range(draws):
        y, chances = rng.standard_normal(160), []
        for _ in range(10):
            found = diagnosed(linear, [], noise=y, column=rng.normal(size=160))
            found.search.steps[0].hints = [None] * 10
            chances.append(certify(found)["adhesion"])
        least.append(min(chances))
    assert np.mean(np.array(least) < 0.2) < 0.2 + 3.0 * np.sqrt(0.16 / draws)
