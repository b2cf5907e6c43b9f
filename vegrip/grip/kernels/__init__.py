"""The compiled part of the control, as source: one stage a file, from frames of states to those of commands.

The files are ordinary ones, to be read, linted and typed; nothing imports them. Their text stands below the
estimator's kernels in one generated module (:mod:`vegrip.grip.compiled`), which runs as plain Python, by
numba, or as C. Everything is kept in two flat arrays of a finger, ``f`` of real and ``t`` of whole numbers
(:mod:`vegrip.grip.layout`), and in ``g``, what every finger of the grasp needs. No function raises.
"""
