"""Makers of files that are kept in the project, run in a checkout as ``python -m tools.NAME``."""
