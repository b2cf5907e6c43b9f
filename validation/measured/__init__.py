"""Measured recordings whose answer is known, or part of it: what is said of them, and what that foretells."""
