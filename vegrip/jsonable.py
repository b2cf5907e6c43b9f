"""Values as JSON has them."""

import math
from enum import Enum
from typing import Any


def jsonable(value: Any, *, says_infinity: bool = False) -> Any:
    """Return ``value`` for JSON: members of enumerations by name, and no number that is not finite.

    NaN is None, and so is infinity unless it is to be said, as the text ``inf``.
    """
    match value:
        case dict():
            return {str(key): jsonable(one, says_infinity=says_infinity) for key, one in value.items()}
        case list() | tuple():
            return [jsonable(one, says_infinity=says_infinity) for one in value]
        case Enum():
            return value.name
        case float() if not math.isfinite(value):
            return str(float(value)) if says_infinity and math.isinf(value) else None
    return value
