"""Messages of protobuf, whose fields have names only in a descriptor set, as ``protoc`` writes it.

::

    protoc --include_imports --descriptor_set_out=hand.desc hand.proto
"""

from collections.abc import Callable, Mapping
from typing import Any, Final

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import DecodeError
from google.protobuf.message_factory import GetMessageClass

from vegrip.errors import ConfigError, suggestion
from vegrip.transport.mapped.body_paths import Step, Steps

MAKE_ONE: Final = "make it with protoc --include_imports --descriptor_set_out=hand.desc hand.proto"
WHOLE: Final = {
    FieldDescriptor.CPPTYPE_INT32: (-(1 << 31), (1 << 31) - 1),
    FieldDescriptor.CPPTYPE_UINT32: (0, (1 << 32) - 1),
    FieldDescriptor.CPPTYPE_INT64: (-(1 << 63), (1 << 63) - 1),
    FieldDescriptor.CPPTYPE_UINT64: (0, (1 << 64) - 1),
    FieldDescriptor.CPPTYPE_ENUM: (-(1 << 31), (1 << 31) - 1),
    FieldDescriptor.CPPTYPE_BOOL: (0, 1),
}
NUMBER_TYPES: Final = {*WHOLE, FieldDescriptor.CPPTYPE_DOUBLE, FieldDescriptor.CPPTYPE_FLOAT}


class ProtobufBodies:
    """All messages of a hand, by topic."""

    def __init__(self, descriptors: bytes, types: Mapping[str, str], where: str) -> None:
        self._where = where
        self._types = types
        self._pool = DescriptorPool()
        self._names: list[str] = []
        self._classes: dict[str, Any] = {}
        try:
            files = FileDescriptorSet.FromString(descriptors).file
            for file in files:
                self._pool.AddSerializedFile(file.SerializeToString())
                dot = f"{file.package}." if file.package else ""
                self._names += [f"{dot}{message.name}" for message in file.message_type]
        except (DecodeError, TypeError) as error:
            raise ConfigError(f"{where}: is no complete descriptor set ({error}); {MAKE_ONE}") from None
        if not self._names:
            raise ConfigError(f"{where}: describes no message; {MAKE_ONE}")

    def load(self, topic: str, payload: bytes) -> Any:
        try:
            return self._class(topic).FromString(payload)
        except DecodeError as error:
            raise ValueError(str(error)) from None

    def getter(self, topic: str, steps: Steps, where: str) -> Callable[[Any], Any]:
        self.check(topic, steps, where)

        def get(body: Any) -> Any:
            for step in steps:
                body = _follow(body, step)
                if body is None:
                    return None
            return body

        return get

    def check(self, topic: str, steps: Steps, where: str) -> None:
        _check(self._class(topic).DESCRIPTOR, steps, f"{where} on {topic}")

    def put(self, topic: str, body: Any, steps: Steps, value: float) -> Any:
        """Return ``body`` with ``value``; a whole number beyond its field stops at the end of it."""
        message = self._class(topic)() if body is None else body
        _put(message, steps, value)
        return message

    def dump(self, body: Any) -> bytes:
        return bytes(body.SerializeToString())

    def _class(self, topic: str) -> Any:
        if topic not in self._classes:
            name = self._types.get(topic, "")
            if not name:
                raise ConfigError(
                    f"{self._where}: the map does not say which message comes on {topic!r}: "
                    f'[messages."{topic}"] type = "{self._names[0]}"'
                )
            try:
                self._classes[topic] = GetMessageClass(self._pool.FindMessageTypeByName(name))
            except KeyError:
                raise ConfigError(
                    f"{self._where}: there is no message {name!r}; {suggestion(name, self._names, 'it has')}"
                ) from None
        return self._classes[topic]


def _follow(body: Any, step: Step) -> Any:
    if isinstance(step, int):
        return body[step] if step < len(body) else None
    if isinstance(step, tuple):
        key, value = step
        return next((entry for entry in body if str(getattr(entry, key)) == value), None)
    if not hasattr(body, "DESCRIPTOR"):  # a map field
        return body.get(step)
    is_there = not body.DESCRIPTOR.fields_by_name[step].has_presence or body.HasField(step)
    return getattr(body, step) if is_there else None


def _check(message: Any, steps: Steps, where: str) -> None:
    field: Any = None
    is_list = False
    for step in steps:
        if is_list:
            is_list = False
            if isinstance(step, str) != _is_map(field):
                raise ConfigError(f"{where}: {field.name!r} has several; write {_entries(field)}")
            if _is_map(field):
                if field.message_type.fields_by_name["key"].type != FieldDescriptor.TYPE_STRING:
                    raise ConfigError(
                        f"{where}: the keys of {field.name!r} are no texts; a path cannot name them"
                    )
                field = field.message_type.fields_by_name["value"]
                message = field.message_type
            elif isinstance(step, tuple):
                _field(message, step[0], where)
            continue
        if not isinstance(step, str) or message is None:
            raise ConfigError(
                f"{where}: {field.name if field else 'the message'!r} has no parts like {step!r}"
            )
        field = _field(message, step, where)
        is_list, message = field.is_repeated, field.message_type
    if is_list:
        raise ConfigError(f"{where}: {field.name!r} has several; write {_entries(field)}")
    if field.cpp_type not in NUMBER_TYPES:
        raise ConfigError(f"{where}: {field.full_name} is no number")


def _field(message: Any, name: str, where: str) -> Any:
    field = message.fields_by_name.get(name) if message is not None else None
    if field is None:
        names = list(message.fields_by_name) if message is not None else []
        raise ConfigError(
            f"{where}: {message.full_name if message is not None else 'a number'} has no field {name!r}; "
            f"{suggestion(name, names, 'it has')}"
        )
    return field


def _is_map(field: Any) -> bool:
    return field.message_type is not None and bool(field.message_type.GetOptions().map_entry)


def _entries(field: Any) -> str:
    return f"{field.name}.KEY" if _is_map(field) else f"{field.name}[0]"


def _put(message: Any, steps: Steps, value: float) -> None:
    name, rest = str(steps[0]), steps[1:]
    field = message.DESCRIPTOR.fields_by_name[name]
    if not field.is_repeated:
        if rest:
            _put(getattr(message, name), rest, value)
        else:
            setattr(message, name, _number(field, value))
        return
    entries, step, rest = getattr(message, name), rest[0], rest[1:]
    if _is_map(field):
        inner = field.message_type.fields_by_name["value"]
        if rest:
            _put(entries[step], rest, value)
        else:
            entries[step] = _number(inner, value)
    elif field.message_type is None:
        entries.extend([_number(field, 0.0)] * (int(str(step)) + 1 - len(entries)))
        entries[step] = _number(field, value)
    else:
        _put(_entry(entries, step), rest, value)


def _entry(entries: Any, step: Step) -> Any:
    if isinstance(step, int):
        while len(entries) <= step:
            entries.add()
        return entries[step]
    assert isinstance(step, tuple)  # noqa: S101 (looked at by check)
    key, value = step
    found = next((entry for entry in entries if str(getattr(entry, key)) == value), None)
    if found is None:
        found = entries.add()
        is_whole = found.DESCRIPTOR.fields_by_name[key].cpp_type in WHOLE
        setattr(found, str(key), int(value) if is_whole else value)
    return found


def _number(field: Any, value: float) -> float | int | bool:
    if field.cpp_type not in WHOLE:
        return value
    low, high = WHOLE[field.cpp_type]
    whole = min(max(round(value), low), high)
    return bool(whole) if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL else whole
