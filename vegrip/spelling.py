"""What to say of an unknown name: the nearest known one, or all of them."""

from collections.abc import Iterable
from difflib import get_close_matches

MANY = 12  # names; more are not listed beside a near one


def suggestion(name: object, known: Iterable[str], there: str = "there are") -> str:
    """Return the end of a sentence about the unknown ``name``.

    >>> suggestion("adhesoin", ["adhesion", "rolling"])
    'there are adhesion, rolling; did you mean adhesion?'
    >>> suggestion("x", [])
    'there are none'

    """
    known = list(known)
    near = get_close_matches(str(name), known, n=1, cutoff=0.7)
    near = near or [one for one in known if one.rpartition(".")[2] == str(name)]
    listed = f"{there} {', '.join(known) or 'none'}"
    if not near:
        return listed
    asked = f"did you mean {near[0]}?"
    return asked if len(known) > MANY else f"{listed}; {asked}"
