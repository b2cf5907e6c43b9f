"""The model check page: a model against a recording, what it lacks, and effects added and taken back.

Everything it does is a command of vegrip that it runs in a process of its own, and shows.
"""
