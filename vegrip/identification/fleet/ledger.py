"""What has been examined already, one line of JSON each, so that a run that was stopped goes on."""

import hashlib
import json
import math
from pathlib import Path

from vegrip import __version__
from vegrip.errors import InputError
from vegrip.identification.fleet.found import Found
from vegrip.identification.fleet.row import Row


class Ledger:
    """A file that grows by a line per recording.

    Args:
        path: of the file; made when it is not there.
        model: text of the model file that diagnoses start from; other models have other lines.

    """

    def __init__(self, path: Path, model: str = "") -> None:
        self.path = path
        self._context = hashlib.sha256(f"{__version__}\n{model}".encode()).hexdigest()[:16]
        self._known: dict[str, Row] = {}
        if path.exists():
            self._read()

    def row(self, found: Found) -> Row | None:
        """Return what is known of a recording as it is now; None when it has to be examined."""
        return self._known.get(self._key(found))

    def add(self, found: Found, row: Row) -> None:
        """Write a row down at once, unless only the machine kept the recording from being examined.

        Raises:
            InputError: it cannot be written.

        """
        if row.is_machine_failure:
            return
        self._known[self._key(found)] = row
        told = {key: None if _is_missing(value) else value for key, value in row.as_dict().items()}
        try:
            with self.path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps({"key": self._key(found), **told}) + "\n")
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written ({error.strerror or error})") from None

    def _key(self, found: Found) -> str:
        return f"{self._context}:{found.fingerprint}:{found.path}"

    def _read(self) -> None:
        """Take in what is there; a last line that was cut off is examined again."""
        for line in self.path.read_text(encoding="utf-8").splitlines():
            try:
                told = json.loads(line)
                key = told.pop("key")
                told |= {name: tuple(told[name]) for name in ("effects", "doubts")}
                told |= {name: math.nan for name in ("before", "after") if told[name] is None}
                self._known[key] = Row(**told)
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
                continue


def _is_missing(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)
