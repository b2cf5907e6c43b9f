"""What a search says while it goes on."""

from types import SimpleNamespace

import pytest

from vegrip.identification.diagnosis import score_tests, search


class RefitsBeginError(Exception):
    """The test ends where the fits begin."""


@pytest.mark.parametrize(("names", "said"), [(["adhesion", "inertia"], "adhesion, inertia"), ([], "none")])
def test_a_step_says_how_many_effects_it_screens_and_which_it_refits(monkeypatch, names, said) -> None:
    hints = [SimpleNamespace(candidate=SimpleNamespace(name=name)) for name in names]

    def refitted(*_):
        raise RefitsBeginError

    some = [SimpleNamespace(name="one", effect=SimpleNamespace(group="")) for _ in range(3)]
    monkeypatch.setattr(search, "candidates", lambda *_: (some, {}))
    monkeypatch.setattr(search, "screen_candidates", lambda *_: hints)
    monkeypatch.setattr(search, "shortlist", lambda given: given)
    monkeypatch.setattr(search, "required_evidence", lambda *_: None)
    monkeypatch.setattr(search, "_refitted", refitted)
    model = SimpleNamespace(values={})
    base = SimpleNamespace(problem=SimpleNamespace(model=model, measured=None), optimum=None)
    found = SimpleNamespace(out_of_sight={}, steps=[], accepted=[], dropped=[], misfit=lambda _: 1.0)
    told = []
    with pytest.raises(RefitsBeginError):
        search._step(base, None, found, 1, told.append)
    assert told == ["screens 3 effects", f"refits {said}"]


def test_an_expensive_effect_and_one_with_a_name_that_is_taken_are_screened_alone(monkeypatch) -> None:
    def candidate(name, **given):
        return SimpleNamespace(name=name, effect=SimpleNamespace(expensive=False, **given))

    monkeypatch.setattr(score_tests, "widened", lambda _, group: len(group))
    monkeypatch.setattr(score_tests, "share_a_name", lambda one, _: one.clashes)
    cheap = [candidate("adhesion", clashes=True), candidate("mine", clashes=False)]
    clashing, expensive = candidate("theirs", clashes=True), candidate("saturation", clashes=False)
    expensive.effect.expensive = True
    given = [cheap[0], clashing, expensive, cheap[1]]
    assert score_tests._groups(None, given) == [(2, cheap), (1, [clashing]), (1, [expensive])]
    assert score_tests._groups(None, [expensive]) == [(1, [expensive])]
