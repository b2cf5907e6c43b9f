"""What CAN logs are called; apart from what reads them, which loads python-can."""

from typing import Final

LOGS: Final = (".asc", ".blf", ".trc", ".mf4", ".mdf")
LOGS_OR_CANDUMP: Final = (*LOGS, ".log")
"""With what candump's are called, and other things as well."""
