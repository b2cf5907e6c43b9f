"""Libraries that are needed for foreign files only: imported on use, asked for in one sentence."""

import importlib
from typing import Any

from vegrip.errors import UsageError


def bag_library(module: str) -> Any:
    """Import ``module``, which comes with the extra ``bags``.

    Raises:
        UsageError: it is not installed.

    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        library = module.partition(".")[0]
        raise UsageError(
            f"this file needs the library {library} ({error.name} is missing): pip install 'vegrip[bags]'"
        ) from None
