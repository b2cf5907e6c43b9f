"""Grip control of a hand: fingertip states in, slip margins and force commands out.

Pure code with time passed in, one idea per file::

    FingertipState -> watchdog ---- Condition -+
    estimator ------> Demand -> policy --------+-> balance -> fail_safe -> limits -> ForceCommand

:class:`~vegrip.grip.finger_controller.FingerController` composes them for a finger,
:class:`~vegrip.grip.node.GraspForce` for a hand. Every command passes the limits, whatever made it.
"""
