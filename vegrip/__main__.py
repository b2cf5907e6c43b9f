"""``python -m vegrip`` is the command line ``vegrip``."""

from vegrip.cli import entry

entry()
