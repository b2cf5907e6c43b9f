"""The compiled part of the control, as source: one stage a file, from frames of states to those of commands.

The files are ordinary ones, to be read, linted and typed; nothing imports them. Their text stands below the
estimator's kernels in one generated module (:mod:`vegrip.grip.compiled`), which runs as plain Python, by
numba, or as C. Everything is kept in two arrays of a finger, ``f`` of real and ``t`` of whole numbers, whose
sections and numbers have names (:mod:`vegrip.grip.records`): ``f.grip.envelope`` is written as a place when
the module is generated. ``g`` is what every finger of the grasp needs. No function raises.
"""
