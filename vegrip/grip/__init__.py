"""Grip control of a hand: fingertip states in, slip margins and force commands out.

One text with time passed in, :mod:`vegrip.grip.kernels`, a stage a file::

    FingertipState -> watchdog ---- condition -+
    estimator ------> demand -> policy --------+-> share -> fail_safe -> limits -> ForceCommand

:class:`~vegrip.grip.finger.GraspFinger` is a view of a finger's numbers,
:class:`~vegrip.grip.node.GraspForce` the node of a hand. Every command passes the limits, whatever made it.
"""
