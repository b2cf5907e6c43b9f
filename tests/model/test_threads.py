"""Models may be composed in many threads at once."""

from concurrent.futures import ThreadPoolExecutor

from vegrip.effects import BUILT_IN, effect
from vegrip.model import BASE, paper_model


def test_the_text_of_a_model_is_the_same_from_any_number_of_threads():
    names = [name for name in BUILT_IN if name not in BASE]
    base = paper_model(8e-3)

    def text(name):
        return base.with_effect(effect(name)).source([], ["advance"])

    alone = [text(name) for name in names]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(3):
            assert list(pool.map(text, names)) == alone
