"""Watching running nodes: what is known of every finger, and a live table of it."""

from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.table import render

__all__ = ["Board", "render"]
