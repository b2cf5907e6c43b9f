"""The methods paragraph of a report, and BibTeX of all that it cites: to be copied into a paper. Pure."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from vegrip.web.markup import section
from vegrip.web.report.bibtex import bibtex, references, software

Answer = Mapping[str, Any]
WHITENING, SOLVER, EVIDENCE = "DurbinKoopman2012", "Marquardt1963", "MacKay1992"
FILTER, LINEARISATION = "SarkkaSvensson2023", "GarciaFernandez2015"
CONTACT, LIMIT_SURFACE = "TiezziKao2007", "GoyalRuinaPapadopoulos1991"


def methods_of_model(answer: Answer) -> str:
    """Return the section of an :func:`~vegrip.identification.diagnosis.account.account`."""
    effects, found = answer["effects"], answer["diagnosis"]
    sentences = [_measured(answer["data"]), _modelled(effects), _fitted(answer["versions"])]
    keys = [*(key for one in effects for key in one["cites"]), SOLVER, WHITENING]
    if found is not None:
        noise = "; ".join(f"{_name(name)}, {source}" for name, source in found["noise"].items())
        sentences += [f"Sources of the noise: {noise}"] if noise else []
        sentences.append(f"Candidate effects were compared by their evidence {_cited([EVIDENCE])}")
        keys.append(EVIDENCE)
    sentences += [_outcome(answer["ladder"]), f"Verdict: {answer['verdict']}"]
    return _section(sentences, keys, answer["versions"])


def methods_of_run(answer: Answer, versions: Answer) -> str:
    """Return the section of :func:`~vegrip.identification.recording.session.summarise_run`."""
    fingers = answer["fingers"]
    seconds = max(one["duration"] for one in fingers.values())
    sentences = [
        f"Grip forces of {len(fingers)} fingers ({', '.join(fingers)}) were recorded for {seconds:.0f} s",
        "Contact force, radius and slip margin are estimates of vegrip by a Kalman filter "
        f"{_cited([FILTER])}, linearised over the spread of the belief {_cited([LINEARISATION])}, of a "
        f"viscoelastic contact {_cited([CONTACT])}; the margin is the distance to the limit surface of force "
        f"and torque {_cited([LIMIT_SURFACE])}",
        "The run does not keep the model files of its fingers: state the effects of each beside this",
        f"The report was made with vegrip {versions['vegrip']}",
    ]
    return _section(sentences, [FILTER, LINEARISATION, CONTACT, LIMIT_SURFACE], versions)


def _measured(data: Answer) -> str:
    table = f" (SHA-256 of the table {data['sha256']})" if data["sha256"] else ""
    return (
        f"{data['rows']} samples over {data['duration']:.1f} s in {data['episodes']} episodes were recorded "
        f"with a fingertip of radius {1e3 * data['tip_radius']:.3g} mm{table}"
    )


def _modelled(effects: Sequence[Answer]) -> str:
    laws = (f"{_name(one['name'])}, {one['summary']} {_cited(one['cites'])}" for one in effects)
    return f"The contact was modelled by {'; '.join(laws)}"


def _fitted(versions: Answer) -> str:
    return (
        f"Parameters were fitted with vegrip {versions['vegrip']} by damped least squares {_cited([SOLVER])} "
        f"on residuals whitened by their noise {_cited([WHITENING])}"
    )


def _outcome(ladder: Sequence[Answer]) -> str:
    first, last = ladder[0]["error"], ladder[-1]["error"]
    added = [_name(rung["effect"]) for rung in ladder if rung["effect"] is not None]
    if not added:
        return f"The model left {last:.2f} times the noise, and no effect was added"
    return f"Adding {', '.join(added)} changed the error from {first:.2f} to {last:.2f} times the noise"


def _section(sentences: Sequence[str], keys: Sequence[str], versions: Answer) -> str:
    own = sorted(set(keys) - set(references()))
    note = f"<p>Sources that the list of references lacks: {escape(', '.join(own))}.</p>" if own else ""
    entries = f"{software(versions['vegrip'])}\n\n{bibtex(keys)}"
    return section(
        "methods, to cite",
        f"<p>{escape('. '.join(sentences))}.</p>{note}",
        f'<h3>BibTeX</h3><pre class="command">\n{escape(entries)}</pre>',
    )


def _cited(keys: Sequence[str]) -> str:
    return f"[{', '.join(keys)}]"


def _name(name: str) -> str:
    return name.replace("_", " ")
