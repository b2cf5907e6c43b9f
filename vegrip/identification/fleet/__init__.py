"""Many recordings at once: which hand, which pad, which effect, since when."""

from vegrip.identification.fleet.findings import Finding, findings
from vegrip.identification.fleet.found import Found, look_for
from vegrip.identification.fleet.row import Row, examined
from vegrip.identification.fleet.workers import run

__all__ = ["Finding", "Found", "Row", "examined", "findings", "look_for", "run"]
