"""A hand of any make: a file says which of its signals make up a FingertipState and a ForceCommand.

:mod:`vegrip.transport.maps` declares the file, ``plan`` resolves it, ``codec`` turns messages of a CAN bus, a
device or a network into states, ``commands`` turns commands into messages, and ``price`` says what the hand
does not send and what that costs. :mod:`vegrip.connect` makes the map of an unknown hand.
"""
