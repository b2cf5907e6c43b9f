"""Grip control: what force a finger shall apply, and what happens when its input cannot be believed.

Pure code with time passed in, one idea per file::

    FingertipState -> watchdog ---- Condition ------------+
    estimator ------> Demand -> policy (grip, baselines) -+-> balance -> fail_safe -> limits -> ForceCommand

:class:`~vegrip.control.finger.FingerController` composes them. Every command passes the limits, whatever
made it.
"""
