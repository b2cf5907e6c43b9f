"""The errors vegrip raises, one small family.

::

    VegripError
     +-- UsageError     the caller asked for something that does not exist (exit code 2)
     |    +-- KindError     an argument is of another kind than is wanted, which is named; a TypeError too
     +-- InputError     what was read is not usable: recording, configuration, wire (exit code 3)
     |    +-- ConfigError
     |    +-- RecordingError
     +-- ModelError     a contact model that cannot be built, with the remedy (exit code 3)
     +-- DomainError    a query outside the range where the answer is known; never extrapolated (exit code 3)
     +-- DeviceError    bus, socket or process that cannot be opened or was lost (exit code 4)

The message is one sentence that says what is wrong and what to do. Errors are for building and for the
command line; inside the real-time loop nothing raises, outputs are flagged and counted instead.
"""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import TypeGuard


class VegripError(Exception):
    """Any error of vegrip; ``exit_code`` is what the command line returns."""

    exit_code = 1


class UsageError(VegripError):
    """The caller asked for something that does not exist."""

    exit_code = 2


class KindError(UsageError, TypeError):
    """An argument is of another kind than is wanted; names what is."""


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


def first_line(error: BaseException) -> str:
    r"""Return the first line of what ``error`` says, or else its kind.

    >>> first_line(ValueError("no number\nin line 3")), first_line(ValueError())
    ('no number', 'ValueError')

    """
    return str(error).strip().partition("\n")[0] or type(error).__name__


MANY = 12  # names; more are not listed beside a near one


def listed(names: Iterable[str]) -> str:
    """Return ``names`` as a sentence has them, in quotes where a comma would be taken for the next.

    >>> listed(["t", "Fz, gf"])
    "t, 'Fz, gf'"

    """
    return ", ".join(repr(name) if "," in name else name for name in names)


def suggestion(name: object, known: Iterable[str], there: str = "there are") -> str:
    """Return the end of a sentence about the unknown ``name``.

    >>> suggestion("adhesoin", ["adhesion", "rolling"])
    'there are adhesion, rolling; did you mean adhesion?'
    >>> suggestion("x", [])
    'there are none'

    """
    known = list(known)
    near = get_close_matches(str(name), known, n=1, cutoff=0.7)
    near = near or [one for one in known if one.rpartition(".")[2] == str(name)]
    sentence = f"{there} {listed(known) or 'none'}"
    if not near:
        return sentence
    asked = f"did you mean {near[0]}?"
    return asked if len(known) > MANY else f"{sentence}; {asked}"
