"""Hand, drives, sensors and control of a trial as text that is compiled with the estimator's kernels.

The physics is that of :mod:`vegrip.virtual` and the control that of :mod:`vegrip.grip`, written once more for
one flat array ``h``, so that a whole trial is one compiled call; the estimator's kernels are the very same.
``tests/trials/test_compiled_loop.py`` holds both against the uncompiled loop. Faults of the
input are not part of it: there is no watchdog.
"""
