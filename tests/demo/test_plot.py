"""Nothing in the picture of the demonstration covers anything else."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vegrip.demo import plot
from vegrip.validation.controllers.closed_loop import Course
from vegrip.validation.controllers.scenario import Scenario

DURATION = 30.0


@pytest.fixture(scope="module", params=range(4))
def figure(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Figure:
    """The picture of made-up courses through the disturbances of a seed."""
    made: list[Figure] = []
    course = Course(("thumb", "index"))
    for t in np.arange(0.0, DURATION, 0.1):
        course.time.append(float(t))
        course.margin.append([0.5, 0.5])
        course.force.append([15.0, 15.0])  # as high as the axis goes
        course.slipped.append(0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plot, "Figure", lambda **more: made.append(Figure(**more)) or made[-1])
        events = Scenario(request.param, DURATION, "pinch").events
        names = ("vegrip", "constant", "cone")
        path = tmp_path_factory.mktemp("picture") / "picture.png"
        plot.picture(dict.fromkeys(names, course), events, path, DURATION)
    FigureCanvasAgg(made[0]).draw()
    return made[0]


def test_the_legend_lies_outside_of_the_axes(figure: Figure) -> None:
    (legend,) = figure.legends
    assert not any(legend.get_window_extent().overlaps(axes.get_window_extent()) for axes in figure.axes)
    assert all(axes.get_legend() is None for axes in figure.axes)


def test_no_name_of_a_disturbance_covers_another_name_or_a_bar_beside_it(figure: Figure) -> None:
    strip = figure.axes[0]
    names = [text.get_window_extent() for text in strip.texts]
    assert not any(one.overlaps(other) for one, other in combinations(names, 2))
    for i, name in enumerate(names):
        others = [bar.get_window_extent() for j, bar in enumerate(strip.patches) if j != i]
        assert not any(name.overlaps(bar) for bar in others)


def test_every_name_is_inside_the_picture(figure: Figure) -> None:
    inside = figure.axes[0].get_window_extent()
    for text in figure.axes[0].texts:
        box = text.get_window_extent()
        assert inside.x0 - 1.0 <= box.x0
        assert box.x1 <= inside.x1 + 1.0


def test_it_says_what_to_see(figure: Figure) -> None:
    assert "how hard each controller grips" in figure.get_suptitle()
