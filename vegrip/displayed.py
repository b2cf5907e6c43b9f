"""Values that show themselves: printed, in a notebook, drawn, as a table, as JSON.

What they show is in :mod:`vegrip.display`, one module a kind of value. It stands below everything that it
shows, so it is found by its name, when something is shown and not before.
"""

import importlib
import json
from typing import TYPE_CHECKING, Any, ClassVar

from vegrip.errors import UsageError
from vegrip.jsonable import jsonable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_LINES = 15
"""Lines that ``print`` gives at most."""


class Displayed:
    """A value with a short ``repr``, a text of at most 15 lines, and a card in a notebook."""

    __slots__ = ()
    _display: ClassVar[str]  # module of vegrip.display

    @property
    def _shows(self) -> Any:
        return importlib.import_module(f"vegrip.display.{self._display}")

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._shows.brief(self)}>"

    def __str__(self) -> str:
        return "\n".join(self._shows.text(self, MOST_LINES).splitlines()[:MOST_LINES])

    def _repr_html_(self) -> str:
        return str(self._shows.card(self))


class Listed(type):
    """Lets ``help()`` be a screen: the text of a class, which names its attributes, and what a user calls."""

    def __dir__(cls) -> list[str]:
        return list(cls.__dict__.get("_calls", Result._calls))


class Result(Displayed, metaclass=Listed):
    """What a computation gave: also drawn, as a table and as JSON."""

    __slots__ = ()
    _calls: ClassVar[tuple[str, ...]] = ("plot", "table", "to_json")

    def plot(self, channel: str = "") -> "Figure":
        """Draw it, of one channel where it has several: the normal force when none is named."""
        drawn: Figure = self._shows.figure(self, channel)
        return drawn

    def table(self) -> Any:
        """Return it as a pandas.DataFrame; as a dict of arrays where pandas is not installed."""
        import numpy as np  # noqa: PLC0415 (the messages, which are Displayed, do without)

        columns = {name: np.asarray(values) for name, values in self._shows.columns(self).items()}
        try:
            pandas = importlib.import_module("pandas")
        except ImportError:
            return columns
        return pandas.DataFrame(columns)

    def to_json(self) -> str:
        """Return what ``--json`` prints."""
        return json.dumps(jsonable(self._shows.as_json(self)), allow_nan=False)


def one_of(channel: str, known: list[str]) -> str:
    """Return ``channel``, the first of ``known`` where it is empty.

    Raises:
        UsageError: it is not one of them.

    """
    if channel and channel not in known:
        raise UsageError(f"there is no channel {channel!r}; it is one of {', '.join(known)}")
    return channel or known[0]
