"""Fields <-> msgpack objects, one small function for each kind of field of ``messages.toml``."""

import math
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, Final

from vegrip.messages import Estimate
from vegrip.transport.codec.schema import Enumeration, Field

TEXT_LIMIT: Final = 64  # characters
MAP_LIMIT: Final = 64  # entries
MSGPACK_LIMITS: Final = {
    "max_str_len": TEXT_LIMIT * 4,  # bytes
    "max_array_len": 8,
    "max_map_len": MAP_LIMIT,
    "max_bin_len": 0,
    "max_ext_len": 0,
}
SEQUENCE_MODULUS: Final = 1 << 32
INT64_MIN: Final = -(1 << 63)
INT64_MAX: Final = (1 << 63) - 1
NAME: Final = re.compile(r"[A-Za-z0-9_\-./]{1,64}")

Convert = Callable[[Any], Any]


class RefusedError(Exception):
    """Why a payload is no message; never leaves the codec."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


def packer(field: Field) -> Convert:
    """Return value -> msgpack object, None to leave the field out; RefusedError: it cannot be carried."""
    if field.enumeration is not None:
        return int
    if field.kind == "float":
        return lambda value: _pack_float(value, field)
    return _PACK[field.kind]


def unpacker(field: Field) -> Convert:
    """Return msgpack object -> value; anything else raises RefusedError."""
    enumeration = field.enumeration
    if enumeration is not None:
        return lambda item: _enumerated(item, enumeration)
    if field.kind == "float":
        return lambda item: _float(item, field)
    return _UNPACK[field.kind]


def _pack_float(value: float, field: Field) -> float | None:
    if math.isfinite(value) or (field.infinite and not math.isnan(value)):
        return float(value)
    if math.isnan(value) and not field.required:
        return None
    raise RefusedError("value")


def _pack_estimate(estimate: Estimate) -> list[float | bool]:
    if math.isinf(estimate.value):
        raise RefusedError("value")
    return [float(estimate.value), float(estimate.std), bool(estimate.valid), float(estimate.age)]


def _pack_counts(counts: Mapping[str, int]) -> dict[str, int]:
    return {name[:TEXT_LIMIT]: _integer(int(count)) for name, count in list(counts.items())[:MAP_LIMIT]}


def _integer(item: Any, high: int = INT64_MAX) -> int:
    if type(item) is not int:  # a bool is an int for isinstance
        raise RefusedError("type")
    if not 0 <= item <= high:
        raise RefusedError("value")
    return item


def checked_time(item: Any) -> int:
    """Return a time [ns] that is an int64; what else msgpack can carry would overflow in numpy later."""
    if type(item) is not int:
        raise RefusedError("type")
    if not INT64_MIN <= item <= INT64_MAX:
        raise RefusedError("value")
    return item


def _float(item: Any, field: Field) -> float:
    value = _number(item)
    if value - value == 0.0:
        return value
    if field.required or (math.isinf(value) and not field.infinite):
        raise RefusedError("value")
    return value


def _number(item: Any) -> float:
    if type(item) is float:
        return item
    if type(item) is int:  # other languages send whole numbers so
        return float(item)
    raise RefusedError("type")


def _flag(item: Any) -> bool:
    if type(item) is not bool:
        raise RefusedError("type")
    return item


def _text(item: Any) -> str:
    if type(item) is not str:
        raise RefusedError("type")
    if len(item) > TEXT_LIMIT:
        raise RefusedError("size")
    return item


def _name(item: Any) -> str:
    if not _is_name(_text(item)):
        raise RefusedError("value")
    return str(item)


@lru_cache(maxsize=256)
def _is_name(text: str) -> bool:
    return NAME.fullmatch(text) is not None


def _estimate(item: Any) -> Estimate:
    if type(item) is not list or len(item) != 4:
        raise RefusedError("type")
    value = _number(item[0])
    if math.isinf(value):
        raise RefusedError("value")
    return Estimate(value, _number(item[1]), _flag(item[2]), _number(item[3]))


def _counts(item: Any) -> dict[str, int]:
    if type(item) is not dict:
        raise RefusedError("type")
    return {_text(name): _integer(count) for name, count in item.items()}


def _enumerated(item: Any, enumeration: Enumeration) -> Any:
    try:
        return enumeration(_integer(item))
    except ValueError:
        raise RefusedError("value") from None


_PACK: Final[Mapping[str, Convert]] = {
    "time": lambda value: checked_time(int(value)),
    "sequence": lambda value: int(value) % SEQUENCE_MODULUS,
    "name": str,
    "flag": bool,
    "count": lambda value: _integer(int(value)),
    "text": lambda value: value[:TEXT_LIMIT],
    "estimate": _pack_estimate,
    "counts": _pack_counts,
}
_UNPACK: Final[Mapping[str, Convert]] = {
    "time": checked_time,
    "sequence": lambda item: _integer(item, SEQUENCE_MODULUS - 1),
    "name": _name,
    "flag": _flag,
    "count": _integer,
    "text": _text,
    "estimate": _estimate,
    "counts": _counts,
}
