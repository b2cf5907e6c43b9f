"""Golden answers: digests of what today's code answers, on every wire, to inputs that are kept.

``python -m validation.golden`` (or ``make golden``) runs all cases and compares with
``validation/golden.json``. Nothing here asks how an answer is found: bytes (or messages) go in at given
times, bytes come out.
"""
