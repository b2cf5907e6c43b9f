"""Differences of times that may lie anywhere in 64 bits: a clock that jumps must not overflow them."""

LONGEST_HALF_NS = 2305843009213693952  # half of 146 years
FARTHEST_NS = 9000000000000000000  # 285 years
LONGEST_STEP = 0.1  # [s]; a longer pause between two states counts as so much


def elapsed_time(later: int, earlier: int) -> int:
    """Return ``later - earlier`` [ns], at most 146 years either way."""
    half = later // 2 - earlier // 2
    if half >= LONGEST_HALF_NS:
        return 2 * LONGEST_HALF_NS
    if half <= -LONGEST_HALF_NS:
        return -2 * LONGEST_HALF_NS
    return later - earlier


def step_time(later: int, earlier: int) -> float:
    """Return the time from one state [ns] to the next [s], as far as it counts."""
    return min(max(float(elapsed_time(later, earlier)) / 1e9, 0.0), LONGEST_STEP)


def bounded_time(time: int) -> int:
    """Return ``time`` [ns] within 285 years, so that a setting can be added or taken off."""
    return min(max(time, -FARTHEST_NS), FARTHEST_NS)
