"""How far and how fast a protocol moves the normal axis."""

import math
from itertools import pairwise

from vegrip.identification.simulate import Protocol


def greatest_depth(protocol: Protocol) -> float:
    """Return the greatest depth that is imposed [m], sines included; forces are not looked at."""
    deepest = 0.0
    for episode in protocol.episodes:
        level = 0.0
        for segment in episode:
            level = segment.depth if segment.depth is not None else level
            deepest = max(deepest, level + (segment.amplitude if segment.force is None else 0.0))
    return deepest


def greatest_speed(protocol: Protocol) -> float:
    """Return the greatest speed of the normal axis where depth is imposed [m/s], sines included."""
    fastest = 0.0
    for episode in protocol.episodes:
        levels = [0.0]
        for segment in episode:
            levels.append(segment.depth if segment.depth is not None else levels[-1])
            if segment.force is None:
                fastest = max(fastest, 2.0 * math.pi * segment.frequency * segment.amplitude)
        moves = zip(episode, pairwise(levels), strict=True)
        fastest = max(fastest, *(abs(b - a) / s.duration for s, (a, b) in moves if s.force is None))
    return fastest
