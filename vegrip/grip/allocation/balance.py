"""Balance of the internal forces of a grasp: the thumb carries what the fingers press.

The fingers press the object against the thumb, so at rest the normal forces obey (no weight along the normal)

    N_thumb = sum_i N_i .

Given the least force ``m`` that each finger needs on its own, the smallest forces that obey it and give every
finger at least its need are

    S = max(m_thumb, sum_i m_i),      N_i = S m_i / sum_i m_i,      N_thumb = S .

Every finger's minimum comes first: nothing is ever lowered to reach the balance. What the balance adds is
internal force that the wrench does not need; it is the price of one thumb.
"""

from collections.abc import Mapping


def balanced(needs: Mapping[str, float], thumb: str) -> dict[str, float]:
    """Return the forces [N] of all fingers that balance about ``thumb`` with every need met.

    A hand without that thumb, or with nothing else, is returned as it is. When no finger opposing the thumb
    needs anything, they share the thumb's need equally.
    """
    fingers = [name for name in needs if name != thumb]
    if thumb not in needs or not fingers:
        return dict(needs)
    pressed = sum(needs[name] for name in fingers)
    total = max(needs[thumb], pressed)
    if pressed > 0.0:
        return {name: total if name == thumb else total * (needs[name] / pressed) for name in needs}
    return {name: total if name == thumb else total / len(fingers) for name in needs}
