"""What changed between two recordings of one fingertip."""

from vegrip.identification.changed.changes import changed
from vegrip.identification.changed.result import Change, Changed

__all__ = ["Change", "Changed", "changed"]
