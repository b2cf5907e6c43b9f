"""What a test bench does with one fingertip: episodes made of segments, as data.

In a segment the bench moves the normal axis from where it is to a depth (indentation imposed) or to a force
(force imposed), evenly over the duration, or holds what it imposed last; meanwhile the counter-surface may
slide and turn at constant speed. A sine may be added to what is imposed.
"""

from dataclasses import dataclass

from vegrip.virtual.settings import FingertipSettings


@dataclass(frozen=True)
class Segment:
    """One stretch of a trial."""

    duration: float  # [s]
    depth: float | None = None  # [m] to reach at the end
    force: float | None = None  # [N] to reach at the end
    amplitude: float = 0.0  # [m] or [N] of the sine
    frequency: float = 0.0  # [Hz]
    pull_x: float = 0.0  # [m/s] speed of the counter-surface
    pull_y: float = 0.0  # [m/s]
    spin: float = 0.0  # [rad/s]


Episode = tuple[Segment, ...]
"""Segments one after the other; the fingertip is fully recovered at the beginning, 0.2 s of air around it."""

AIR = Segment(0.2, depth=0.0)


def hold(depth: float, duration: float, rise: float = 0.1) -> Episode:
    """Press fast to ``depth`` [m], hold it, and withdraw."""
    return (AIR, Segment(rise, depth=depth), Segment(duration), Segment(0.3, depth=0.0), Segment(1.0))


def creep(force: float, duration: float, rise: float = 0.1) -> Episode:
    """Load fast to ``force`` [N], hold it, and withdraw."""
    return (AIR, Segment(rise, force=force), Segment(duration), Segment(0.3, depth=0.0), Segment(1.0))


def triangles(depth: float, speed: float, cycles: int) -> Episode:
    """Press to ``depth`` [m] and back at ``speed`` [m/s], several times."""
    stroke = depth / speed
    return (AIR, *(Segment(stroke, depth=depth), Segment(stroke, depth=0.0)) * cycles, AIR)


def sine(depth: float, amplitude: float, frequency: float, cycles: int) -> Episode:
    """Press to ``depth`` [m] and move up and down about it."""
    wave = Segment(cycles / frequency, amplitude=amplitude, frequency=frequency)
    return (AIR, Segment(0.3, depth=depth), Segment(0.5), wave, Segment(0.3, depth=0.0), AIR)


def slip(
    force: float, wait: float, *, pull: float = 0.0, spin: float = 0.0, duration: float = 1.5
) -> Episode:
    """Load to ``force`` [N], wait, then pull [m/s] and turn [rad/s] until well after slip."""
    move = Segment(duration, pull_x=pull, spin=spin)
    return (AIR, Segment(0.1, force=force), Segment(wait), move, Segment(0.3), Segment(0.3, depth=0.0), AIR)


def standard_protocol(tip: FingertipSettings, *, size: float = 1.0) -> tuple[Episode, ...]:
    """Return presses, creep, triangles, sines, pulls and twists scaled to the fingertip.

    The deepest press reaches ``size`` x 20 % of the radius; forces are those of the depths; speeds are such
    that a pull lasts many times the presliding.
    """
    depth = 0.2 * size * tip.radius

    def at(part: float) -> float:
        force: float = tip.reference_force * (part * depth / tip.reference_indentation) ** tip.exponent
        return force

    pull, spin = 0.4 * depth, 0.6
    return (
        *(hold(part * depth, 6.0) for part in (0.4, 0.7, 1.0)),
        *(creep(at(part), 6.0) for part in (0.4, 0.7)),
        *(triangles(0.8 * depth, speed * depth, 2) for speed in (0.4, 2.0, 10.0)),
        *(sine(0.6 * depth, 0.2 * depth, f, cycles) for f, cycles in ((0.5, 3), (5.0, 20))),
        *(slip(at(part), wait, pull=pull) for part in (0.3, 0.5, 0.7) for wait in (0.3, 4.0)),
        *(slip(at(part), 0.5, spin=spin) for part in (0.3, 0.6)),
        slip(at(0.5), 4.0, spin=spin),
        slip(at(0.5), 0.5, pull=pull, spin=0.4 * spin),
        *(slip(at(0.5), 0.5, pull=speed * pull, duration=1.5 / speed) for speed in (0.5, 2.0, 6.0)),
    )
