"""The errors vegrip raises, one small family.

::

    VegripError
     +-- UsageError     the caller asked for something that does not exist (exit code 2)
     +-- InputError     what was read is not usable: recording, configuration, wire (exit code 3)
     |    +-- ConfigError
     |    +-- RecordingError
     +-- ModelError     a contact model that cannot be built, with the remedy (exit code 3)
     +-- DomainError    a query outside the range where the answer is known; never extrapolated (exit code 3)
     +-- DeviceError    bus, socket or process that cannot be opened or was lost (exit code 4)

The message is one sentence that says what is wrong and what to do. Errors are for building and for the
command line; inside the real-time loop nothing raises, outputs are flagged and counted instead.
"""

from pathlib import Path
from typing import TypeGuard


class VegripError(Exception):
    """Any error of vegrip; ``exit_code`` is what the command line returns."""

    exit_code = 1


class UsageError(VegripError):
    """The caller asked for something that does not exist."""

    exit_code = 2


class InputError(VegripError):
    """What was read cannot be used."""

    exit_code = 3


class ConfigError(InputError):
    """A configuration file or value that cannot be used; names file and key."""


class RecordingError(InputError):
    """A recording that cannot be used; names file and line."""


class ModelError(VegripError):
    """A contact model that cannot be built; names the effect and the remedy."""

    exit_code = 3


class DomainError(VegripError, ValueError):
    """A query outside the range in which the answer is known."""

    exit_code = 3


class DeviceError(VegripError):
    """A bus, socket or process that cannot be opened or was lost."""

    exit_code = 4


def is_missing_from_installation(error: BaseException) -> TypeGuard[FileNotFoundError]:
    """Whether ``error`` is that a file of vegrip itself is not there: nothing of the user's is wrong."""
    return isinstance(error, FileNotFoundError) and Path(__file__).parent in Path(str(error.filename)).parents
