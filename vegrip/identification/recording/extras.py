"""Libraries that come with an extra."""

import importlib
from typing import Any

from vegrip.errors import UsageError


def extra_library(module: str, extra: str) -> Any:
    """Import ``module``, which comes with ``extra``."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        name = module.partition(".")[0]
        raise UsageError(
            f"this file needs the library {name} ({error.name} is missing): pip install 'vegrip[{extra}]'"
        ) from None
