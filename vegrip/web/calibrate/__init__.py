"""The calibration page: which trial is next, what the last one lacks, what is known of the fingertip.

Everything it does is ``vegrip calibrate`` with an option, in a process of its own, and is shown.
"""
