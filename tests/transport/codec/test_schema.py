"""messages.toml declares what vegrip.messages defines, field for field."""

import dataclasses
import enum
import typing
from typing import Any

import pytest

from vegrip import messages
from vegrip.errors import ConfigError
from vegrip.messages import Estimate
from vegrip.transport.codec.schema import CLASSES, Field, message_set, parse, read_proto

DECLARED = {float: "float", bool: "flag", Estimate: "estimate"}

every_kind = pytest.mark.parametrize("cls", CLASSES.values(), ids=CLASSES)


def fields(cls: type[Any]) -> tuple[Field, ...]:
    return message_set().messages[cls].fields


@every_kind
def test_the_fields_are_those_of_the_class_in_its_order(cls: type[Any]) -> None:
    assert [f.name for f in fields(cls)] == [f.name for f in dataclasses.fields(cls)]


@every_kind
def test_a_field_is_required_when_the_class_has_no_default(cls: type[Any]) -> None:
    missing = dataclasses.MISSING
    required = [
        f.name for f in dataclasses.fields(cls) if f.default is missing and f.default_factory is missing
    ]
    assert [f.name for f in fields(cls) if f.required] == required


@every_kind
def test_the_types_are_those_of_the_class(cls: type[Any]) -> None:
    hints = typing.get_type_hints(cls)
    for field in fields(cls):
        hint = hints[field.name]
        if isinstance(hint, type) and issubclass(hint, enum.Enum):
            assert field.kind == hint.__name__
        elif hint in DECLARED:
            assert field.kind == DECLARED[hint]
        elif hint is int:
            assert field.kind in ("time", "sequence", "count")
        elif hint is str:
            assert field.kind in ("name", "text")
        else:
            assert field.kind == "counts"


@every_kind
def test_every_float_has_a_unit(cls: type[Any]) -> None:
    assert all(f.unit for f in fields(cls) if f.kind in ("float", "estimate", "time"))


def test_the_version_is_that_of_the_messages() -> None:
    assert message_set().version == messages.VERSION
    assert f"Version {messages.VERSION}" in read_proto("README.md")


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("version = 1\n[Grip]\ntopic = '/x'\n[Grip.fields]\n", "Grip"),
        (
            "version = 1\n[SlipMargin]\ntopic = '/x'\n[SlipMargin.fields]\nx = { type = 'quaternion' }\n",
            "quaternion",
        ),
        (
            "version = 1\n[SlipMargin]\ntopic = '/x'\n[SlipMargin.fields]\nx = { type = 'flag', size = 3 }\n",
            "size",
        ),
    ],
)
def test_a_schema_that_names_what_does_not_exist_is_refused(text: str, names: str) -> None:
    with pytest.raises(ConfigError, match=names):
        parse(text)
