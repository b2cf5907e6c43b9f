"""Model files come back as they were written, and complain with file and key."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vegrip.effects import effect
from vegrip.errors import ConfigError, ModelError
from vegrip.model import Shown, paper_model, read_model, write_model


@settings(max_examples=25, deadline=None)
@given(
    K=st.floats(1e-12, 1e6),
    p=st.floats(0.8, 4.0),
    radius=st.floats(1e-7, 0.1),
    note=st.text(st.characters(codec="utf-8", exclude_categories=["Cs"])),
)
def test_a_model_round_trips_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, K: float, p: float, radius: float, note: str
) -> None:
    path = tmp_path_factory.mktemp("model") / "model.toml"
    model = paper_model(radius).with_value("K", K, std=math.pi).with_value("p", p, learn=False)
    model = model.with_effect(effect("second_relaxation"))
    model.provenance["recording"] = note  # type: ignore[index]
    model = dataclasses.replace(model, shown=Shown(depth=K, load=p, warmest=radius))
    write_model(model, path)
    assert read_model(path) == model


def test_missing_parameters_take_the_declared_default(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    write_model(paper_model(8e-3), path)
    text = path.read_text()
    short = "\n".join(line for line in text.splitlines() if not line.startswith(("mu =", "nu1 =")))
    path.write_text(short.replace("reference_temperature", "# reference_temperature"))
    assert read_model(path).values["nu1"].value == 3.1


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("tip_radius", "tip_diameter"), "unknown key 'tip_diameter'"),
        (("[fingertip]", "[finger]"), "unknown key 'finger'"),
        (("value = 1.5", "value = 9.0"), "p is 9"),
        (('"coulomb_friction"', '"coulomb"'), "no effect 'coulomb'"),
        (("learn = true", "learn = 1"), "'learn' is 1"),
        (("value = 1.5", 'value = "1.5"'), "must be a number"),
        (("[fingertip]", "[fingertip"), "not valid TOML"),
    ],
)
def test_a_broken_file_is_refused_in_one_sentence(
    tmp_path: Path, change: tuple[str, str], complaint: str
) -> None:
    path = tmp_path / "model.toml"
    write_model(paper_model(8e-3), path)
    path.write_text(path.read_text().replace(*change))
    with pytest.raises((ConfigError, ModelError), match=complaint):
        read_model(path)


def test_a_read_model_gives_the_same_forces(tmp_path: Path) -> None:
    model = paper_model(8e-3)
    write_model(model, tmp_path / "m.toml")
    t, delta = np.linspace(0, 1, 50), np.linspace(0, 1e-3, 50)
    again = read_model(tmp_path / "m.toml").simulate(t, delta)
    np.testing.assert_array_equal(again.normal_force, model.simulate(t, delta).normal_force)
