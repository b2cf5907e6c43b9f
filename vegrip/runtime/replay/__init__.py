"""Replays: recordings sent through the same codec, loop and node as live data, in simulated time."""
