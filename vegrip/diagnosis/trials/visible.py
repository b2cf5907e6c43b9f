"""What a hidden effect leaves that anybody could see.

The same recording is made without the effect, noise and all, and the paper's model fitted to both: what the
fit leaves more where the effect is hidden is what a perfect candidate could gain. A recording in which that
is next to nothing cannot tell, and says nothing of a diagnosis.
"""

import numpy as np

from vegrip.diagnosis.trials.cases import Case, recorded
from vegrip.errors import VegripError
from vegrip.fit.recipe import fit
from vegrip.recording import Recording

VISIBLE = 10.0  # [nats]; a name among thirty candidates pays five, and three or more for its parameters


def leaves(case: Case) -> dict[str, float]:
    """Return what each hidden effect by itself leaves of the recording of a case [nats]."""
    if not case.hidden:
        return {}
    plain = excess(recorded(case, only=()))
    return {name: excess(recorded(case, only=(name,))) - plain for name in case.hidden}


def excess(recording: Recording) -> float:
    """Return what the fitted paper's model leaves more than noise [nats]; inf where it cannot be fitted."""
    try:
        found = fit(recording)
    except VegripError:
        return float("inf")
    residual = found.optimum.residual[found.problem.counted]
    return 0.5 * float(np.sum(residual**2 - 1.0))
