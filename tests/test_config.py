"""Parameters are typed and bounded wherever they come from."""

from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip import config
from vegrip.errors import ConfigError
from vegrip.runtime.lifecycle import rows, with_value


@dataclass(frozen=True)
class Limits:
    highest: float = config.parameter(20.0, unit="N", low=0.1, high=100.0, doc="largest grip force")


@dataclass(frozen=True)
class Grip:
    finger: str = config.parameter(doc="name of the finger")
    margin: float = config.parameter(0.3, unit="1", low=0.05, high=0.9)
    policy: str = config.parameter("limit_surface", choices=("limit_surface", "cone"))
    verbose: bool = config.parameter(False)
    repeats: int = config.parameter(3, low=1, high=10)
    settles: float = config.constant(0.1, unit="s")
    limits: Limits = field(default_factory=Limits)


def test_a_table_becomes_a_typed_group() -> None:
    grip = config.build(Grip, {"finger": "thumb", "margin": 0.5, "limits": {"highest": 12}}, "hand.toml")
    assert grip == Grip("thumb", margin=0.5, limits=Limits(12.0))
    assert isinstance(grip.limits.highest, float)


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({}, r"hand.toml: the key 'finger' is missing \(name of the finger\)"),
        ({"finger": "thumb", "margni": 0.3}, "unknown key 'margni'; known are finger, margin"),
        ({"finger": "thumb", "margin": 0.95}, r"'margin' is 0.95; it must lie in 0.05 .. 0.9$"),
        ({"finger": "thumb", "margin": float("nan")}, "'margin' is nan"),
        ({"finger": "thumb", "margin": "much"}, "'margin' is 'much'; it must be a float"),
        ({"finger": "thumb", "margin": True}, "'margin' is True; it must be a float"),
        ({"finger": "thumb", "repeats": 2.5}, "'repeats' is 2.5; it must be a whole number"),
        ({"finger": "thumb", "policy": "hope"}, "it must be one of limit_surface, cone"),
        (
            {"finger": "thumb", "settles": 0.1},
            "hand.toml: 'settles' is a constant and no parameter; leave it out",
        ),
        ({"finger": "thumb", "limits": 3}, "'limits' is 3; it must be a table$"),
        (
            {"finger": "thumb", "limits": {"highest": 0}},
            r"hand.toml.limits: 'highest' is 0; it must lie in 0.1 .. 100 N",
        ),
    ],
)
def test_a_wrong_table_is_refused_in_one_sentence(table: dict[str, object], sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence) as refused:
        config.build(Grip, table, "hand.toml")
    assert "\n" not in str(refused.value)


@given(st.floats())
def test_a_replaced_value_lies_within_its_bounds_or_is_refused(value: float) -> None:
    grip = Grip("thumb")
    if 0.05 <= value <= 0.9:
        assert config.replace(grip, "margin", value).margin == value
    else:
        with pytest.raises(ConfigError):
            config.replace(grip, "margin", value)
    assert grip.margin == 0.3


def test_a_constant_is_neither_listed_nor_set_by_anything_but_python() -> None:
    known = {name for name, *_ in rows(Grip("thumb", settles=0.2))}
    assert known == {"finger", "margin", "policy", "verbose", "repeats", "limits.highest"}
    with pytest.raises(ConfigError, match="there is no parameter 'settles'"):
        with_value(Grip("thumb"), "settles", 0.1, False, "grip")


def test_an_unknown_parameter_is_refused_with_the_known_names() -> None:
    with pytest.raises(ConfigError, match="there is no parameter 'force'; there are finger, margin"):
        config.replace(Grip("thumb"), "force", 1.0)


def test_a_broken_file_is_refused_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "hand.toml"
    file.write_text("margin = 0.3\nfinger = \n")
    with pytest.raises(ConfigError, match=r"hand.toml: is not valid TOML.*line 2"):
        config.read_toml(file)
    with pytest.raises(ConfigError, match="there is no such file"):
        config.read_toml(tmp_path / "absent.toml")


@given(st.floats())
def test_a_group_made_in_python_is_refused_where_its_table_is(value: float) -> None:
    grip = Grip("thumb", margin=value, limits=Limits(20.0))
    if 0.05 <= value <= 0.9:
        config.check(grip, "hand")
    else:
        with pytest.raises(ConfigError, match=r"^hand: 'margin' is .*; it must lie in 0.05 .. 0.9$"):
            config.check(grip, "hand")


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"limits": Limits(0.0)}, "hand.limits: 'highest' is 0; it must lie in 0.1 .. 100 N"),
        ({"limits": 3}, "hand: 'limits' is 3; it must be a Limits"),
        ({"policy": "hope"}, "it must be one of limit_surface, cone"),
        ({"settles": float("nan")}, "'settles' is nan"),
    ],
)
def test_of_a_group_made_in_python_all_that_is_inside_is_looked_at(
    given: dict[str, object], sentence: str
) -> None:
    with pytest.raises(ConfigError, match=sentence):
        config.check(Grip("thumb", **given), "hand")  # type: ignore[arg-type]
