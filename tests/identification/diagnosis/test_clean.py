"""Where the known physics holds its numbers are the true ones."""

from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.diagnosis import clean
from vegrip.identification.diagnosis.candidate_fit import evaluate_candidate, held_out_groups
from vegrip.identification.fit import fit

KINDS = ("hold", "ramp", "hold", "ramp", "hold", "ramp")
TRUE = {"K": 1.8, "p": 1.5, "c1": 0.3, "nu1": 3.0}  # of the fingertip of a few lines


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "variable"),
    [
        ({"crack": (70.0, -0.1)}, "time"),
        ({"late": ("lag", 0.01)}, "speed"),
        ({"branches": ((0.3, 3.0), (0.1, 0.3))}, "time_in_contact"),
    ],
)
def test_the_range_in_which_the_model_holds_is_told_and_the_bias_falls_there(tip, given, variable) -> None:
    recording = tip(12, kinds=KINDS, **given)
    found = fit(recording)
    fitted = evaluate_candidate(found.problem, found.optimum, held_out_groups(found.problem))
    everywhere, holds = found.model.values, clean.find_clean(fitted)
    assert holds.variable == variable
    assert holds.beyond > 1.5 > holds.error
    before, after = (
        np.mean([abs(np.log(at(name) / true)) for name, true in TRUE.items()])
        for at in (lambda name: everywhere[name].value, holds.parameters.__getitem__)
    )
    assert after < 0.85 * before


def fit_of(t, touching):
    """Return a fit that is only numbers, of which the widest range is looked for."""
    problem = SimpleNamespace(
        stiffness=np.where(touching, 9.0, 0.0),
        used=np.ones(t.size, bool),
        unknowns=SimpleNamespace(start=None, names=("K", "p"), log=(True, False)),
    )
    return SimpleNamespace(problem=problem, optimum=SimpleNamespace(u=np.zeros(2)))


@pytest.mark.parametrize(
    ("variable", "low", "high", "share"),
    [
        ("time", 0.0, 59.0, 0.5),  # of contact that begins at 20
        ("time", 29.0, 99.0, 0.7),
        ("indentation", 0.0, 33.0, 0.3),
        ("speed", 0.0, 86.0, 0.85),
        ("speed", 85.5, 999.0, 0.0),
    ],
)
def test_the_side_of_a_variable_with_most_rows_in_which_the_model_holds_is_told(
    monkeypatch, variable, low, high, share
) -> None:
    """The model holds, by decree, as long as no row in contact leaves a range of one variable."""
    t, rng = np.arange(120.0), np.random.default_rng(4)
    touching = t >= 20.0
    values = {name: np.r_[-50.0 * np.ones(20), rng.permutation(np.arange(100.0))] for name in clean.VARIABLES}
    values["time"] = t - 20.0
    values["indentation"] = np.where(touching, values["indentation"], np.where(t < 10.0, -14.0, -15.0))

    def fitted(_, u, kept, inside):
        assert np.array_equal(kept & touching, inside)
        assert np.array_equal(np.flatnonzero(kept & ~touching), np.arange(10, 20))  # too high to feel it
        x = values[variable][inside]
        return (np.array([0.7, 0.2]), 1.01, 3.0) if low <= x.min() and x.max() <= high else None

    monkeypatch.setattr(clean, "features_of", lambda *_: SimpleNamespace(values=values))
    monkeypatch.setattr(clean, "scaled", lambda _, start: start)
    monkeypatch.setattr(clean, "_fitted", fitted)
    found = clean.find_clean(fit_of(t, touching))
    if not share:
        assert found is None
        return
    assert (found.variable, found.share) == (variable, pytest.approx(share, abs=0.011))
    assert (found.low is None, found.high is None) == (low == 0.0, low > 0.0)
    edge = found.high if found.low is None else found.low
    assert edge == pytest.approx(99.0 * (share if low == 0.0 else 1.0 - share), abs=1.0)
    assert (found.error, found.beyond) == (1.01, 3.0)
    assert found.parameters == {"K": pytest.approx(np.exp(0.7)), "p": 0.2}
    assert (
        f"({found.share:.0%} of the contact, 1.01 times the noise); beyond, it leaves 3 times" in found.note
    )


@pytest.mark.parametrize(("error", "holds"), [(0.9, True), (1.04, True), (1.06, False)])
def test_a_range_holds_up_to_an_error_of_five_percent_over_the_noise(linear, error, holds) -> None:
    rng = np.random.default_rng(7)
    X, y, inside = rng.normal(size=(400, 2)), rng.standard_normal(400), np.arange(400) < 200
    y[inside] -= X[inside] @ np.linalg.lstsq(X[inside], y[inside], rcond=None)[0]
    y[inside] *= error / np.sqrt(np.mean(y[inside] ** 2))
    y[~inside] *= 3.0
    fit = SimpleNamespace(problem=linear(y, X, np.array([9.0, 9.0])))
    told = clean._fitted(fit, np.ones(2), inside, inside)
    assert (told is not None) == holds
    if told is not None:
        assert told[0] == pytest.approx([0.0, 0.0], abs=1e-2)
        assert told[1] == pytest.approx(error, rel=1e-3)
        assert told[2] == pytest.approx(np.sqrt(np.mean(y[~inside] ** 2)), rel=1e-3)
