"""What changed between two recordings of one fingertip."""

from vegrip.identification.changed.changes import Changed, changed
from vegrip.identification.changed.words import Change

__all__ = ["Change", "Changed", "changed"]
