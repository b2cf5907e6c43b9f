"""Trials of drafts: recordings with laws of kinds that the grammar does not hold, each by two protocols."""
