"""Where the functions of a generated module were written, and what they say of themselves."""

from vegrip.effects import effect
from vegrip.estimator.origins import Origins
from vegrip.model import paper_model


def test_hooks_have_their_docstrings_and_places() -> None:
    origins = Origins(paper_model(8e-3).with_effect(effect("adhesion")).effects)
    notes = origins.notes()
    assert any("relaxed" in note for name, note in notes.items() if "relaxation" in name)
    assert all(isinstance(note, str) for note in notes.values())
    hook = next(name for name in notes if "adhesion" in name)
    assert "adhesion.py:" in origins.place(hook, 0)
    assert origins.place("no_such_function", 2) == "no_such_function, statement 3"
