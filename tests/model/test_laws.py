"""The check that authors of effects run passes what is sound and names what is not."""

import dataclasses
import math

import pytest

from vegrip.effects import BUILT_IN, Effect, State, effect, hook
from vegrip.model import BASE
from vegrip.model.laws import broken_laws
from vegrip.parameters import Parameter


@pytest.mark.parametrize("name", [name for name in BUILT_IN if name not in BASE])
def test_every_effect_of_the_catalogue_holds_to_the_laws(name):
    assert broken_laws(effect(name)) == []


def factor(elastic_force, s_f):
    return elastic_force * (1.0 + s_f)


def always(elastic_force, s_f):
    return elastic_force + 0.1 + 0.0 * s_f


def unbounded(elastic_force, s_f):
    return elastic_force * math.exp(s_f * 1e3)


def counting(force, s_f, counted):
    return force + s_f * counted, counted + 1.0


def foreign(elastic_force, s_f):
    return elastic_force * len(str(s_f))


def made(function, stage="elastic", **fields):
    parameter = Parameter("s_f", "1", 0.1, 0.1, 0.0, 1.0, "something", null=0.0)
    sound = Effect("made", "made for a test", ("own",), (hook(function, stage=stage),), (parameter,))
    return dataclasses.replace(sound, **fields)


def test_a_sound_effect_breaks_none():
    assert broken_laws(made(factor)) == []


NO_NULL = (Parameter("s_f", "1", 0.1, 0.1, 0.0, 1.0, "something"),)
OUTSIDE = (Parameter("s_f", "1", 5.0, 0.1, 0.0, 1.0, "something", null=0.0),)


def filtered_by_sample(force, dt, s_f, smooth):
    """A low pass whose coefficient belongs to the sample and not to the time that has passed."""
    smooth = smooth + (0.03 * (force - smooth) if dt > 0.0 else 0.0)
    return force + s_f * (smooth - force), smooth


SMOOTH = (State("smooth", "N", "the filtered force"),)
STRONG = (Parameter("s_f", "1", 0.9, 0.1, 0.0, 1.0, "something", null=0.0),)
COUNT = (State("counted", "1", "how often it was called"),)


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (made(always), "at its null values the model differs"),
        (made(always), "s_f moves no output"),
        (made(unbounded), "high bounds the result is not finite"),
        (made(counting, "force", states=COUNT), "reading the present state"),
        (made(factor, parameters=NO_NULL), "no parameter has a null value"),
        (made(factor, parameters=OUTSIDE), "outside its bounds"),
        (made(factor, cites=()), "cites nothing"),
        (
            made(filtered_by_sample, "force", states=SMOOTH, parameters=STRONG),
            "shorter steps do not lead to one result",
        ),
        (made(foreign), "may use math"),
    ],
)
def test_what_breaks_a_law_is_told_in_a_sentence(broken, words):
    assert any(words in sentence for sentence in broken_laws(broken))
