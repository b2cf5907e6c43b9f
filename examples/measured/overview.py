"""The table over all recordings."""

from cases import Case, Result, si

HEAD = (
    "recording",
    "peak force",
    "node, rms error",
    "model alone, rms error",
    "mean NIS",
    "fails most",
    "refused",
    "learned by then",
)


def overview(results: dict[Case, Result]) -> str:
    """Return the table; errors are those within the window of the case."""
    lines = [f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|"]
    for case, result in results.items():
        told = result.told()
        peak = float(result.recording.columns["normal_force"].max())
        node = result.error(result.estimated_force(), case.window)
        alone = result.error(result.alone, case.window)
        failing = next(iter(told["failing"]), "-")
        learned = ", ".join(_spoken(symbol, *pair) for symbol, pair in result.learned.items())
        cells = (
            case.name,
            si(peak),
            f"{si(node)} ({node / peak:.1%})",
            f"{si(alone)} ({alone / peak:.1%})",
            f"{told['nis']:.2f}",
            failing,
            f"{told['rejected']} of {told['samples']}",
            learned,
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _spoken(symbol: str, value: float, std: float) -> str:
    """A learned parameter as people read it; K and the rates are known by their logarithm."""
    if symbol == "K":
        return f"K {si(value)} ± {std:.0%}"
    if symbol.startswith("nu"):
        return f"{symbol} {value:.2g} /s ± {std:.0%}"
    return f"{symbol} {value:.2f} ± {std:.2f}"
