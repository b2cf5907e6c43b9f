"""A CAN bus in software: frame times, arbitration, error confinement, and the virtual bus made of them.

Light on purpose: python-can loads this package for any user of the ``vegrip`` interface.
"""
