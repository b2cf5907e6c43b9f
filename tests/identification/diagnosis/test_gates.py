"""What a candidate must pass, and which verdict follows, on fits that are only numbers."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.identification.diagnosis import acceptance, diagnosis
from vegrip.identification.diagnosis.acceptance import Verdict, drives_onto_bound, judge_candidate
from vegrip.identification.diagnosis.diagnosis import Diagnosis, are_alike
from vegrip.identification.diagnosis.score_tests import _is_allowed
from vegrip.identification.diagnosis.search import Search

PLACES = SimpleNamespace(names=["K", "pull"], low=np.array([1.0, 0.0]), high=np.array([9.0, 4.0]))
STD = np.array([0.5, 0.5])


def fitted(
    evidence=0.0, heldout=(0.0, 0.0, 0.0, 0.0), error=1.0, u=(5.0, 2.0), effects=("power_law_stiffness",)
):
    unknowns = SimpleNamespace(**vars(PLACES), std=STD)
    model = SimpleNamespace(effects=[effect(name) for name in effects])
    return SimpleNamespace(
        evidence=evidence,
        heldout=np.array(heldout),
        error=error,
        problem=SimpleNamespace(unknowns=unknowns, model=model),
        optimum=SimpleNamespace(u=np.array(u)),
    )


BASE = fitted(error=1.5)
GOOD = (10.0, 10.0, 10.0, 10.0)


@pytest.fixture(autouse=True)
def resolved(monkeypatch):
    monkeypatch.setattr(acceptance, "is_resolved", lambda *_: True)


def judged(regimes=(9.0, 1.0), pays=8.0, left=math.inf, **new):
    values = {"evidence": 40.0, "heldout": GOOD, "error": 1.0} | new
    candidate = SimpleNamespace(effect=dataclasses.replace(effect("adhesion"), min_gain=0.0))
    return judge_candidate(candidate, BASE, fitted(**values), regimes, pays, left)


def test_a_candidate_that_passes_all_gates_is_told_with_what_it_gains() -> None:
    told = judged()
    assert (told.gain, told.heldout, told.failed, told.is_passed) == (40.0, 40.0, (), True)


@pytest.mark.parametrize(
    ("failed", "passes", "fails"),
    [
        ("evidence", {"evidence": 8.1}, {"evidence": 8.0}),
        (
            "held-out episodes",
            {"heldout": (50.0, 50.0, -12.0, -12.0)},
            {"heldout": (50.0, 50.0, -13.0, -13.0)},
        ),
        ("held-out episodes", {"heldout": (4.0, 4.0, 0.0, -6.0)}, {"heldout": (3.0, 3.0, 0.0, -6.3)}),
        ("one episode only", {"heldout": (50.0, 0.1, 0.0, 0.0)}, {"heldout": (50.0, 0.0, 0.0, 0.0)}),
        ("regimes", {"regimes": (1.4, 1.3)}, {"regimes": (1.4, 1.4)}),
        ("error", {"error": 1.49}, {"error": 1.5}),
        ("bounds", {"u": (1.0006, 2.0)}, {"u": (1.0004, 2.0)}),
        ("bounds", {"u": (8.9994, 2.0)}, {"u": (8.9996, 2.0)}),
    ],
)
def test_each_gate_has_its_place(failed, passes, fails) -> None:
    assert failed not in judged(**passes).failed
    assert failed in judged(**fails).failed


def test_two_episodes_may_be_explained_in_one_alone() -> None:
    base, new = fitted(heldout=(0.0, 0.0), error=1.5), fitted(40.0, (50.0, -1.0))
    candidate = SimpleNamespace(effect=effect("sensor_lag"))
    assert "one episode only" not in judge_candidate(candidate, base, new, (9.0, 1.0)).failed
    nothing = fitted(40.0, (4.0, -4.0))
    assert "held-out episodes" in judge_candidate(candidate, base, nothing, (9.0, 1.0)).failed


def test_what_takes_most_of_what_is_left_may_lose_more_episodes_and_rule_the_regimes_less() -> None:
    lossy = {"heldout": (40.0, 40.0, 20.0, -50.0), "regimes": (9.0, 9.5)}
    assert judged(**lossy, left=40.0 / 0.31).failed == ()
    assert judged(**lossy, left=40.0 / 0.29).failed == ("held-out episodes", "regimes")


@pytest.mark.parametrize(
    ("base", "new", "candidate", "driven"),
    [
        ((5.0, 2.0), (9.0, 2.0), "adhesion", True),
        ((5.0, 2.0), (5.0, 4.0), "adhesion", False),  # of an effect that was added
        ((8.86, 2.0), (9.0, 2.0), "adhesion", False),  # near it by itself
        ((8.84, 2.0), (9.0, 2.0), "adhesion", True),
        ((5.0, 2.0), (9.0, 2.0), "exponential_stiffness", False),  # takes the place of that law
    ],
)
def test_only_a_base_parameter_that_was_away_from_it_is_driven_onto_a_bound(
    base, new, candidate, driven
) -> None:
    named = SimpleNamespace(effect=effect(candidate))
    assert drives_onto_bound(named, fitted(u=base), fitted(u=new)) is driven


def tried(name, gain, *, change=(1.0, 0.0), failed=()):
    return SimpleNamespace(
        candidate=SimpleNamespace(
            name=name, effect=SimpleNamespace(group="", hooks=(), channels=("normal_force",))
        ),
        verdict=Verdict(gain, gain, failed),
        change=np.array(change),
    )


class Found:
    """Stands for a search: its figures are given."""

    def __init__(self, steps, *, misfit=1.0, error=1.0, first_error=2.0, gained=100.0, is_given_up=False):
        self.is_given_up, self.is_stopped = is_given_up, False
        self.steps, self.dropped, self.general = steps, [], {}
        self.contests = {one.taken.candidate.name: one for one in steps if one.taken is not None}
        self.first = SimpleNamespace(error=first_error, evidence=0.0)
        self.last = SimpleNamespace(error=error, evidence=gained)
        self._misfit = misfit

    @property
    def accepted(self):
        return [one.taken for one in self.steps if one.taken is not None]

    def misfit(self, _):
        return self._misfit

    within = Search.within
    is_rough = Search.is_rough


def step(*given, taken=0):
    return SimpleNamespace(
        base=None, tried=list(given), taken=given[taken] if given and taken is not None else None
    )


def verdict(steps, rest=None, **figures):
    one = Diagnosis(SimpleNamespace(), Found(steps, **figures))
    vars(one)["_rest"] = None if rest is None else SimpleNamespace(gain=rest)
    return one.verdict


NONE = [step(tried("adhesion", 3.0, failed=("evidence",)), taken=None)]
ONE = [step(tried("adhesion", 100.0))]
MANY = [step(tried(name, 100.0)) for name in ("adhesion", "sensor_lag", "saturation")]


@pytest.mark.parametrize(
    ("steps", "figures", "told"),
    [
        (NONE, {}, "adequate"),
        (NONE, {"misfit": 1.6}, "adequate"),
        (NONE, {"misfit": 1.6, "rest": 21.0}, "unexplained"),
        (NONE, {"misfit": 1.4, "rest": 39.0}, "adequate"),
        (NONE, {"misfit": 1.4, "rest": 41.0}, "unexplained"),
        (ONE, {}, "named"),
        (ONE, {"is_given_up": True}, "unexplained"),
        (ONE, {"misfit": 1.6}, "named"),
        (ONE, {"misfit": 1.5, "rest": 11.0}, "named"),
        (ONE, {"misfit": 1.6, "rest": 9.0}, "named"),
        (ONE, {"misfit": 1.6, "rest": 11.0}, "unexplained"),
        (ONE, {"misfit": 1.4, "rest": 11.0}, "named"),
        (MANY[:2], {"misfit": 1.6}, "named"),
        (MANY, {"misfit": 1.6}, "unexplained"),
        (MANY, {"misfit": 1.4}, "named"),
        (ONE, {"error": 1.09, "first_error": 1.2}, "named"),
        (ONE, {"error": 1.11, "first_error": 1.2}, "unexplained"),
        (ONE, {"error": 1.04, "first_error": 1.2, "misfit": 1.6}, "named"),
        (ONE, {"error": 1.06, "first_error": 1.2, "misfit": 1.6}, "unexplained"),
        (ONE, {"error": 1.14, "first_error": math.sqrt(1.0 + 0.2996 / 0.099)}, "named"),
        (ONE, {"error": 1.14, "first_error": math.sqrt(1.0 + 0.2996 / 0.101)}, "unexplained"),
        (ONE, {"error": 1.16, "first_error": 9.0}, "unexplained"),
    ],
)
def test_the_verdict_follows_from_misfit_error_and_what_is_left(steps, figures, told) -> None:
    assert verdict(steps, **figures) == told


@pytest.mark.parametrize(
    ("gain", "other", "alike"),
    [(100.0, 95.1, True), (100.0, 94.8, False), (1e6, 1e6 - 990.0, True), (1e6, 1e6 - 1010.0, False)],
)
@pytest.mark.parametrize("rough", [{}, {"misfit": 1.6}, {"error": 1.03}])
def test_within_five_nats_or_a_thousandth_or_a_hundredth_where_forms_are_rough_both_stand(
    gain, other, alike, rough
) -> None:
    other = gain - (10.0 if rough and gain > 1e3 else 1.0) * (gain - other)
    steps = [step(tried("adhesion", gain), tried("sensor_lag", other, change=(0.0, 1.0)))]
    one = Diagnosis(SimpleNamespace(), Found(steps, **rough))
    vars(one)["_rest"] = None
    assert one.indistinguishable == ([["adhesion", "sensor_lag"]] if alike else [])
    assert one.verdict == ("ambiguous" if alike else "named")
    assert one.named == ([] if alike else ["adhesion"])


def test_a_candidate_that_failed_makes_nothing_ambiguous() -> None:
    failed = tried("sensor_lag", 99.0, failed=("error",))
    assert Diagnosis(SimpleNamespace(), Found([step(tried("adhesion", 100.0), failed)])).verdict == "named"


@pytest.mark.parametrize(
    ("rival", "failed", "verdict"),
    [
        ("layer_over_core", ("held-out episodes", "one episode only"), "ambiguous"),
        ("layer_over_core", ("held-out episodes", "bounds"), "named"),
        ("sensor_lag", ("held-out episodes",), "named"),  # known to resemble something else
    ],
)
def test_of_two_that_resemble_each_other_held_out_episodes_say_nothing(rival, failed, verdict) -> None:
    """One deep press alone may show where a layer ends: without it the right law fails."""
    both = tried("exponential_stiffness", 251.0), tried(rival, 251.2, failed=failed, change=(0.0, 1.0))
    for each in both:
        each.candidate.effect = effect(each.candidate.name)
    one = Diagnosis(SimpleNamespace(), Found([step(*both)]))
    vars(one)["_rest"] = None
    assert one.verdict == verdict


def near(cosine):
    return cosine, math.sqrt(1.0 - cosine**2)


@pytest.mark.parametrize(
    ("gain", "other", "cosine", "alike"),
    [
        (1000.0, 981.0, 0.96, True),
        (1000.0, 1019.0, 0.96, True),
        (1000.0, 979.0, 0.96, False),
        (1000.0, 981.0, 0.94, False),
        (40.0, 31.0, 0.96, True),  # a quarter of the gain
        (40.0, 29.0, 0.96, False),
    ],
)
def test_two_that_do_the_same_differ_by_form_up_to_so_many_nats(gain, other, cosine, alike) -> None:
    a, b = tried("a", gain, change=(2.0, 0.0)), tried("b", other, change=np.multiply(3.0, near(cosine)))
    assert are_alike(a, b) == alike


def test_two_that_do_nothing_are_not_alike() -> None:
    nothing = tried("a", 0.0, change=(0.0, 0.0))
    assert not are_alike(nothing, nothing)


def test_where_nothing_is_named_the_curve_is_that_of_the_first_model(monkeypatch) -> None:
    monkeypatch.setattr(
        diagnosis,
        "find_discrepancy",
        lambda fitted, **_: SimpleNamespace(gain=50.0, of=fitted, variable="time"),
    )
    found = Found(ONE, misfit=1.6)
    assert Diagnosis(SimpleNamespace(), found).unexplained.of is found.first
    calm = Found(ONE, misfit=1.4)
    assert Diagnosis(SimpleNamespace(), calm).unexplained is None
    rough = Found(ONE, misfit=1.6, gained=1e4)
    assert Diagnosis(SimpleNamespace(), rough).unexplained.of is rough.last


@pytest.mark.parametrize(
    ("at", "multiple", "allowed"),
    [
        (1.2, 2.0, True),
        (1.2, 4.0, True),
        (1.2, -4.0, True),
        (1.2, -6.0, False),
        (0.5, 1.7, True),
        (0.5, 1.9, False),
    ],
)
def test_a_trial_stays_on_the_side_of_its_bounds(at, multiple, allowed) -> None:
    """The amount r_mu is nothing at 1 and lies in 0.1 .. 2; beyond the upper bound it is cut, not refused."""
    one = effect("rate_dependent_friction")
    trial = {p.symbol: p.default if p.null is None else p.null for p in one.parameters} | {"r_mu": at}
    assert _is_allowed(SimpleNamespace(effect=one), trial, multiple) == allowed


def test_beyond_the_upper_bound_only_the_other_way_is_refused() -> None:
    one = effect("rate_dependent_friction")
    trial = {p.symbol: p.default if p.null is None else p.null for p in one.parameters} | {"r_mu": 0.5}
    assert not _is_allowed(SimpleNamespace(effect=one), trial, -3.0)
    assert _is_allowed(SimpleNamespace(effect=one), trial | {"r_mu": 1.9}, 3.0)


def told(steps, *, dropped=(), doubts=(), **figures):
    """Return what a diagnosis tells of each candidate, round by round."""
    search = Found(steps, **figures)
    search.dropped = list(dropped)
    for one in [one for each in steps for one in each.tried]:
        behind = SimpleNamespace(is_given_up=one.candidate.name == "behind")
        one.fitted = SimpleNamespace(error=1.25, value=lambda _: 3.0, optimum=behind)
        one.candidate.effect = SimpleNamespace(parameters=(), channels=("normal_force",))
    found = Diagnosis(SimpleNamespace(), search, list(doubts))
    vars(found).update(_rest=None)
    return found


def test_of_those_that_pass_each_is_as_probable_as_its_evidence_and_one_that_fails_is_not() -> None:
    first = step(tried("a", 3.0), tried("b", 2.0), tried("c", 9.0, failed=("error",)))
    second = step(tried("d", -1.0, failed=("evidence", "regimes")), taken=None)
    found = told([first, second])
    total = math.exp(3.0) + math.exp(2.0) + 1.0
    rows = {one["name"]: one for one in found.rounds}
    assert rows["a"]["probability"] == pytest.approx(math.exp(3.0) / total)
    assert rows["b"]["probability"] == pytest.approx(math.exp(2.0) / total)
    assert rows["c"]["probability"] == rows["d"]["probability"] == 0.0
    assert [one["round"] for one in found.rounds] == [1, 1, 1, 2]
    assert [one["taken"] for one in found.rounds] == [True, False, False, False]
    assert (rows["a"]["error_after"], rows["a"]["evidence_gain"], rows["a"]["heldout_gain"]) == (
        1.25,
        3.0,
        3.0,
    )
    assert [rows[name]["outcome"] for name in "abcd"] == [
        "taken",
        "passes, a gains more",
        "fails: error",
        "fails: evidence, regimes",
    ]
    assert [one["name"] for one in found.effects] == ["a", "b", "c", "d"]
    left = told([step(tried("a", 3.0), tried("behind", 2.0)), step(tried("behind", 2.0), taken=None)])
    assert left.rounds[1]["outcome"] == "given up, a gains more"


def test_what_became_of_a_candidate_that_passes_is_told() -> None:
    two = [step(tried("a", 30.0), tried("b", 20.0), taken=1), step(tried("a", 25.0), taken=0)]
    assert [one["name"] for one in told(two).effects] == ["b", "a"]  # the taken ones first
    assert told(ONE, dropped=["adhesion"]).rounds[0]["outcome"] == "taken, and not needed beside the others"
    assert told(ONE, error=1.3).rounds[0]["outcome"] == "taken, not enough"
    suggested = Diagnosis(SimpleNamespace(), told(ONE).search, unproven="one motion")
    assert (suggested.verdict, suggested.named) == ("unexplained", [])
    assert suggested.rounds[0]["outcome"] == "taken, a suggestion"
    spare = [step(tried("a", 30.0)), step(tried("b", 20.0), taken=None)]
    assert told(spare).rounds[1]["outcome"] == "passes, 1 are taken already"
    grave, slight = SimpleNamespace(is_grave=True), SimpleNamespace(is_grave=False)
    assert told(spare, doubts=[slight, grave]).rounds[1]["outcome"] == "passes, the recording is in doubt"
    assert told(spare, doubts=[slight]).rounds[1]["outcome"] == "passes, 1 are taken already"


@pytest.mark.parametrize(
    ("doubts", "accepted", "group", "misfit", "asked", "named"),
    [
        ([False], ["adhesion"], "", 1.0, [30.0], True),
        ([False], ["adhesion"], diagnosis.TIMING, 1.0, [70.0], True),  # beside the others, in its place
        ([], [], "", 1.6, [20.0], False),
        ([], [], "", 1.5, [], False),
        ([True], ["adhesion"], "", 9.0, [], False),
    ],
)
def test_clocks_are_looked_at_where_something_is_left_or_named_and_a_doubtful_recording_names_nothing(
    monkeypatch, doubts, accepted, group, misfit, asked, named
) -> None:
    seen = []
    start = SimpleNamespace(
        problem=SimpleNamespace(
            measured=SimpleNamespace(recording=None),
            model=SimpleNamespace(tip_radius=0.01),
            episodes=np.zeros(1, dtype=int),
        ),
        optimum=None,
    )
    steps = [step(*(tried(name, 30.0) for name in accepted), tried("b", 20.0), taken=0 if accepted else None)]

    def search(*_, most, **__):
        seen.append(most)
        found = Found(steps, misfit=misfit)
        found.last.problem, found.untaken = SimpleNamespace(symbols=()), Found([])
        own = tried("own", 70.0)
        own.candidate.effect.group, own.fitted = group, None
        found.contests = {name: step(own) for name in accepted}
        return found

    monkeypatch.setattr(diagnosis, "noise_of", lambda _: None)
    monkeypatch.setattr(diagnosis, "fit", lambda *_, **__: start)
    monkeypatch.setattr(diagnosis, "refuse_unusable", lambda *_: None)
    monkeypatch.setattr(
        diagnosis, "check_before_search", lambda _: [SimpleNamespace(is_grave=grave) for grave in doubts]
    )
    monkeypatch.setattr(diagnosis, "search_effects", search)
    monkeypatch.setattr(diagnosis, "unproven", lambda *_, **__: "")
    monkeypatch.setattr(diagnosis, "find_discrepancy", lambda _: None)
    monkeypatch.setattr(diagnosis, "find_jump", lambda *_: None)
    monkeypatch.setattr(diagnosis, "left", lambda _: 0.0)
    monkeypatch.setattr(diagnosis, "check_clocks", lambda _, best: seen.append(best) or [])
    found = diagnosis.diagnose.__wrapped__([])
    is_grave = True in doubts
    assert seen == [0 if is_grave else 4, *asked]
    assert len(found.doubts) == len(doubts)
    assert [one.candidate.name for one in found.search.accepted] == (accepted if named else [])
