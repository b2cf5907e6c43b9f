"""A hand of any make: a file says which of its signals make up a FingertipState and a ForceCommand.

``schema`` is the file, ``plan`` what it means, ``decoder`` and ``encoder`` the compiled ways in and out,
``price`` what the hand does not tell and what that costs.
"""
