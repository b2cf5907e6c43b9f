"""Whatever is written as TOML reads back as it was."""

import datetime
import math
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.config import toml_value
from vegrip.transport.maps.map_text import changed_text

TEXT = st.text(st.characters(exclude_categories=["Cs"]))
PLAIN = TEXT | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | st.dates()
VALUES = st.recursive(PLAIN, lambda inner: st.lists(inner) | st.dictionaries(TEXT, inner), max_leaves=8)


@given(VALUES)
def test_every_value_comes_back(value):
    back = tomllib.loads(f"value = {toml_value(value)}")["value"]
    assert back == value
    assert type(back) is type(value)


@pytest.mark.parametrize("text", ["\r", "\r\n", "\x00", "\x1b[31m", "\x7f", "\t", '"', "\\", "\u2028", "😀"])
def test_characters_that_toml_escapes_come_back(text):
    assert tomllib.loads(f"{toml_value(text)} = {toml_value(text)}") == {text: text}


def test_a_number_that_is_none_comes_back():
    assert math.isnan(tomllib.loads(f"value = {toml_value(math.nan)}")["value"])


def test_what_toml_does_not_have_is_refused():
    with pytest.raises(TypeError, match="TOML has no NoneType"):
        toml_value({"there": [None]})
    assert toml_value(datetime.time(12, 30)) == "12:30:00"


@given(TEXT, PLAIN)
def test_a_key_that_is_set_in_a_map_reads_back_whatever_its_name(name, value):
    text = changed_text("", [(["messages", name, "signal"], value)])
    assert tomllib.loads(text)["messages"][name]["signal"] == value
