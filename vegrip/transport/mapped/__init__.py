"""A hand of any make: a file says which of its signals make up a FingertipState and a ForceCommand.

``schema`` declares the file, ``plan`` resolves it, ``codec`` (CAN) and ``topics`` (a network) turn messages
into states and commands into messages, ``price`` says what the hand does not send and what that costs.
``guess``, ``proposal``, ``questions`` and ``find_protection`` make the map of an unknown hand.
"""
