"""What a call is given: of another kind than is wanted, it is refused in one sentence that names what is."""

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from vegrip.errors import KindError, RecordingError, UsageError
from vegrip.identification.fit.noise import Noise
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel

P = ParamSpec("P")
R = TypeVar("R")


def named_kind(given: object) -> str:
    """Return what ``given`` is, in words: a Fit, None, the text 'press'."""
    if isinstance(given, str | Path):
        return f"the text {str(given)!r}"
    name = type(given).__name__
    return "None" if given is None else f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def on_recording(function: Callable[P, R]) -> Callable[P, R]:
    """Let ``function(recording, model=None, *, noise, zeros, laws, ...)`` refuse what it cannot take."""
    known, name = inspect.signature(function), function.__name__

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            given = known.bind(*args, **kwargs).arguments
        except TypeError as error:
            raise KindError(f"{name}: {error}; it takes {', '.join(known.parameters)}") from None
        _check_recording(name, given["recording"])
        _check_rest(name, given)
        return function(*args, **kwargs)

    return checked


def _check_recording(name: str, given: object) -> None:
    if not isinstance(given, Recording):
        raise KindError(
            f"{name} wants a Recording first, and was given {named_kind(given)}{_remedy(name, given)}"
        )
    if not len(given):
        raise RecordingError(
            f"{given.name} holds no row, and so no episode; give {name} a recording of at least one press"
        )


def _remedy(name: str, given: object) -> str:
    if isinstance(given, str | Path):
        read = "read_recording" if Path(given).is_dir() else "import_recording"
        return f"; read it first: {name}(vegrip.{read}({str(given)!r}))"
    if isinstance(given, ContactModel):
        return f"; the model comes second: {name}(recording, model)"
    if hasattr(given, "recording") and hasattr(given, "model"):
        return f"; give the recording and the model of it: {name}(recording, it.model)"
    return "; vegrip.read_recording(FOLDER) or vegrip.import_recording(FILE, ...) gives one"


def _check_rest(name: str, given: dict[str, Any]) -> None:
    model, noise = given.get("model"), given.get("noise")
    if model is not None and not isinstance(model, ContactModel):
        remedy = ""
        if isinstance(model, str | Path):
            remedy = f"; read it first: vegrip.read_model({str(model)!r})"
        elif hasattr(model, "model"):
            remedy = "; give its .model"
        raise KindError(
            f"{name} wants a ContactModel as its model, and was given {named_kind(model)}{remedy}"
        )
    if noise is not None and not isinstance(noise, Noise):
        raise KindError(
            f"{name} wants a Noise as its noise, and was given {named_kind(noise)}; "
            "vegrip.noise_of(recording) gives one, and .tolerant(0.01) allows 1 % of the peak force"
        )
    for key in {"most", "threads"} & given.keys():
        if not isinstance(given[key], int) or given[key] < 0:
            raise KindError(f"{key} is {given[key]!r}; it is a whole number, 0 or more")
    for key in ("zeros", "laws"):
        one = given.get(key, "recording")
        if one not in ("recording", "episode") and not isinstance(one, tuple):
            raise UsageError(
                f"{key} is {one!r}; it is 'recording', 'episode' or a group for each episode, (0, 0, 1)"
            )
