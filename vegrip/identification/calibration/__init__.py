"""Calibration of a new fingertip: which trial is next, whether it shows what it is for, when all is known."""
