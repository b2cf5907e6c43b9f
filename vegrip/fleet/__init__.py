"""Many recordings at once: which hand, which pad, which effect, since when."""

from vegrip.fleet.findings import Finding, findings
from vegrip.fleet.found import Found, look_for
from vegrip.fleet.row import Row, examined
from vegrip.fleet.workers import run

__all__ = ["Finding", "Found", "Row", "examined", "findings", "look_for", "run"]
