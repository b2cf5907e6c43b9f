"""A virtual test bench: one fingertip is driven through a protocol and measured."""
