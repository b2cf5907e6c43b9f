"""Faults on purpose, each with what must happen, run against the real node on a simulated bus.

``python -m validation.faults`` runs the table; ``docs/faults.md`` shows it.
"""
