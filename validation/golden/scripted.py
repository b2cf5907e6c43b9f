"""Scripted time for this process, to be imported before vegrip."""

from validation.golden import world

world.install()
