"""Hands of another make as a file: keys, signals, units, checksums, and the maps in the box."""
