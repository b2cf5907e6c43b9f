"""A recording and a model have one error, whatever command says it: the same rows, zeros by the same rule."""

import json
import re

import pytest

from vegrip.cli import main
from vegrip.identification import samples
from vegrip.identification.compare import compare
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.error_ladder import add_effect
from vegrip.identification.fit import fit
from vegrip.identification.recording import Recording, write_recording

THREE_DIGITS = 5e-4
TWO_TIMES = ((0.3, 3.0), (0.12, 0.25))

pytestmark = pytest.mark.slow


def has_one_error(recording: Recording, effect: str) -> None:
    """Fit, compare and add to a model, as it was fitted and with an effect more."""
    base = fit(recording)
    extended, before = add_effect(effect, base)
    again, before_again = add_effect(effect, fit(recording, base.model))
    for fitted, others in (
        (base, [before.error, before_again.error]),
        (extended, [again.error, fit(recording, extended.model).error]),
    ):
        compared = compare(recording, fitted.model)
        assert (compared.problem.used == base.problem.used).all()
        for error in (compared.error, *others):
            assert error == pytest.approx(fitted.error, rel=THREE_DIGITS)
        for channel, one in fitted.channels.items():
            assert compared.channels[channel].ratio == pytest.approx(one.ratio, rel=1e-3), channel


def test_fit_compare_and_add_say_the_same_of_one_model(tip) -> None:
    recording = tip(3, branches=TWO_TIMES, zeros=(-0.3, -0.15))
    assert fit(recording).problem.doubtful.any()  # rows after taps, which are left out
    has_one_error(recording, "second_relaxation")


def test_they_do_of_the_sample() -> None:
    has_one_error(samples.recording(), "adhesion")


@pytest.mark.long
def test_a_diagnosis_begins_and_ends_with_the_error_of_its_models(tip) -> None:
    recording = tip(4, branches=((0.25, 20.0), (0.15, 0.8)), kinds=("taps",) * 4)
    base = fit(recording)
    assert base.problem.doubtful.any()  # rows after taps, which are left out
    found = diagnose(recording, base.model)
    assert found.error["before"] == pytest.approx(base.error, rel=THREE_DIGITS)
    assert found.error["after"] < 0.7 * base.error
    assert compare(recording, found.model).error == pytest.approx(found.error["after"], rel=THREE_DIGITS)


@pytest.mark.long
def test_commands_print_it_and_hand_it_on(tip, tmp_path, capsys) -> None:
    write_recording(tip(3, kinds=("taps", "hold"), branches=TWO_TIMES, zeros=(-0.3, -0.15)), tmp_path / "tip")
    folder, model, more = (str(tmp_path / name) for name in ("tip", "m.toml", "more.toml"))

    def told(*command: str, in_text: bool = True) -> tuple[float, ...]:
        """Figures of the JSON, which the text holds too."""
        assert main([*command, "--json"]) == 0
        error = json.loads(capsys.readouterr().out)["error"]
        figures = (error["before"], error["after"]) if isinstance(error, dict) else (error,)
        if not in_text:
            return figures
        assert main([arg for i, arg in enumerate(command) if "-o" not in command[max(i - 1, 0) : i + 1]]) == 0
        printed = [float(text) for text in re.findall(r"\d\.\d{3}\b", capsys.readouterr().out)]
        for one in figures:
            assert round(one, 3) in printed
        return figures

    (fitted,) = told("fit", folder, "-o", model)
    before, after = told("add", "second_relaxation", folder, "--model", model, "-o", more)
    assert [fitted] == pytest.approx([before], rel=THREE_DIGITS)
    assert told("compare", folder, "--model", model) == pytest.approx((fitted,), rel=THREE_DIGITS)
    again = told("compare", folder, "--model", more, in_text=False)
    assert again == pytest.approx((after,), rel=THREE_DIGITS)
    assert told("add", "adhesion", folder, "--model", more, in_text=False)[0] == pytest.approx(
        after, rel=THREE_DIGITS
    )
