"""A diagnosis: the verdict first, then what was tried."""

from dataclasses import asdict
from html import escape
from typing import TYPE_CHECKING, Any

from rich.text import Text

from vegrip.display import card as cards
from vegrip.display import comparison, ladder
from vegrip.display.text import Part, first_rows, plain, table_of
from vegrip.displayed import one_of
from vegrip.identification.compare.plot import channel_figure
from vegrip.identification.diagnosis import Diagnosis, thresholds
from vegrip.identification.diagnosis.account import models_of, title_of
from vegrip.identification.diagnosis.error_ladder import build_ladder
from vegrip.identification.fit.result import channel_errors
from vegrip.web.check.render import VERDICTS, channels
from vegrip.web.markup import listed, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SENTENCES = {
    "adequate": "nothing is missing that this recording can show",
    "named": "this explains the misfit:",
    "ambiguous": "one of these explains the misfit; the recording does not separate them:",
    "unexplained": "no effect of the catalogue explains the misfit",
}
WITHIN = "the model leaves less than the noise already; this leaves still less:"
HEAD = ("round", "effect", "evidence [nats]", "held out [nats]", "error", "outcome")
FEWEST_ROWS = 3  # of what was tried, on the first screen
SHOWN = 6  # effects that were tried, in a card


def brief(found: Diagnosis) -> str:
    names = ", ".join([*found.named, *(" or ".join(group) for group in found.indistinguishable)])
    errors = f"{found.error['before']:.3f} -> {found.error['after']:.3f} times the noise"
    return f"of {found.start.recording.name}: {f'{found.verdict} {names}'.rstrip()}, {errors}"


def parts(found: Diagnosis, most: int | None = None) -> list[Part]:
    """Return the first screen of the terminal, in ``most`` lines where it is given."""
    head, tail = _head(found), _tail(found)
    room = None if most is None else max(most - len(head) - len(tail) - 1, FEWEST_ROWS)
    rounds = found.rounds
    if room is not None and len(rounds) > room:  # what was taken stays
        last = [one for one in rounds if not one["taken"]]
        rounds = [one for one in rounds if one["taken"]] + last
    rows, more = first_rows([_row(one) for one in rounds], room)
    tried: list[Part] = [table_of(HEAD, rows, left=("effect", "outcome"))] if rows else []
    return [*head, *tried, *more, *tail]


def text(found: Diagnosis, most: int | None = None) -> str:
    return plain(parts(found, most))


def sentence_of(found: Diagnosis) -> str:
    if found.is_unfinished:
        return "stopped before its end, so nothing is named"
    grave = [doubt.text for doubt in found.doubts if doubt.is_grave]
    if grave:
        return f"not reliable: {'; '.join(grave)}"
    is_within = found.verdict == "named" and found.error["before"] < 1.0
    return WITHIN if is_within else SENTENCES[found.verdict]


def _head(found: Diagnosis) -> list[Part]:
    sure, error = ", ".join(found.named), found.error
    is_all = found.verdict == "named"
    head = Text(f"{found.start.recording.name}: {found.verdict}", style="bold")
    return [
        head + Text(f" - {sentence_of(found)} {sure if is_all else ''}".rstrip(), style="not bold"),
        *([f"named: {sure}"] if sure and not is_all else []),
        *(f"not separated: {', '.join(group)}" for group in found.indistinguishable),
        f"error in units of the noise: {error['before']:.3f} -> {error['after']:.3f} (floor 1)",
    ]


def _row(one: dict[str, Any]) -> tuple[str, ...]:
    gains = (f"{one['evidence_gain']:.1f}", f"{one['heldout_gain']:.1f}", f"{one['error_after']:.3f}")
    return (str(one["round"]), one["name"], *gains, one["outcome"])


def _tail(found: Diagnosis) -> list[Part]:
    """Return what else the search has found: a suggestion, values in SI, what is left and what holds."""
    s, after = found.search, found.error["after"]
    added = ", ".join(one.candidate.name for one in s.accepted)
    notes = (found.unexplained, found.repeated, found.holds)
    said: list[Part] = []
    if suggested := ", ".join(found.suggested) or (added if found.unproven else ""):
        said.append(f"a suggestion: {suggested}, with {after:.3f} times the noise left")
    elif added and found.verdict == "unexplained":
        chi2, noise = s.misfit(s.last), thresholds.MAX_NOISE_CHI2
        said.append(
            f"not enough: with {added} {after:.3f} times the noise is left, and depends on depth, "
            f"motion or time (chi-square by regime {chi2:.3g}; noise: up to {noise:.3g})"
        )
    said += [f"{name} is {value:.3g} {unit}" for name, (value, unit) in found.in_si().items()]
    return said + [note for one in notes if one is not None and (note := one.as_dict()["note"])]


def card(found: Diagnosis) -> str:
    """Return the verdict of the report: what is missing, the error, the ladder, and what was tried."""
    level, name, sentence = VERDICTS[found.verdict]
    if found.verdict == "named":
        level, name, sentence = "ok", f"named: {', '.join(found.named)}", sentence_of(found).rstrip(":")
    if any(doubt.is_grave for doubt in found.doubts):
        level, name, sentence = "bad", "not reliable", sentence_of(found)
    rungs = build_ladder(found)
    error, last = found.error, found.search.last
    tried = [_row(one)[1:] for one in found.effects[:SHOWN]]
    errors = {name: asdict(one) for name, one in channel_errors(last.problem, last.optimum.u).items()}
    notes = [*_head(found)[1:-1], *_tail(found), *(doubt.text for doubt in found.doubts)]
    content = (
        f"<p>{escape(sentence)}</p>",
        listed([str(note) for note in notes]),
        comparison.pictures(models_of(found)),
        ladder.drawn(rungs) if len(rungs) > 1 else "",
        table(HEAD[1:], tried, numbers=(1, 2, 3)) if tried else "",
        channels({"channels": errors}),
    )
    change = f"{error['before']:.2f} → {error['after']:.2f}" if len(rungs) > 1 else f"{error['after']:.2f}"
    heading = f"diagnosis of {found.start.recording.name}"
    return cards.verdict(heading, level, name, cards.times_noise(change), *content)


def figure(found: Diagnosis, channel: str) -> "Figure":
    models = models_of(found)
    known = list(next(iter(models.values())))
    return channel_figure(title_of(found), models, one_of(channel, known))


def columns(found: Diagnosis) -> dict[str, list[Any]]:
    names = (
        "name",
        "round",
        "evidence_gain",
        "heldout_gain",
        "error_after",
        "probability",
        "taken",
        "outcome",
    )
    return {name: [one[name] for one in found.effects] for name in names}


def as_json(found: Diagnosis, draws: int = 0) -> dict[str, Any]:
    """Return what ``--json`` prints; ``draws`` of the bootstrap say how sure the verdict is."""
    from vegrip.identification.diagnosis.certainty import certainty_of  # noqa: PLC0415 (heavy)
    from vegrip.identification.experiment.design import next_experiment  # noqa: PLC0415 (heavy)

    return found.as_dict(next_experiment(found), certainty_of(found, draws).as_dict())
