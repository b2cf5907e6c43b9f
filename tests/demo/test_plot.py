"""Nothing in the picture of the demonstration covers anything else, and it says what it shows."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vegrip.demo import plot
from vegrip.demo.report import AS_FORCEFUL
from vegrip.trials.closed_loop import Course, Scenario

DURATION = 30.0


@pytest.fixture(scope="module", params=range(2))
def figure(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Figure:
    """The picture of made-up courses through the disturbances of a seed."""
    made: list[Figure] = []
    course = Course(("thumb", "index"))
    for t in np.arange(0.0, DURATION, 0.1):
        course.time.append(float(t))
        course.margin.append([0.5, 0.5])
        course.force.append([15.0, 15.0])  # as high as the axis goes
        course.slipped.append(0)
        course.contact.append([(1.0, 1e-3, 0.6, 3e-3, 2.0)] * 2)
        course.friction.append((float(t), 0.7, 0.3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plot, "Figure", lambda **more: made.append(Figure(**more)) or made[-1])
        events = Scenario(request.param, DURATION, "pinch").events
        names = ("vegrip", *(name + end for name in ("constant", "cone") for end in ("", AS_FORCEFUL)))
        path = tmp_path_factory.mktemp("picture") / "picture.png"
        plot.draw_comparison(dict.fromkeys(names, course), events, path, DURATION)
    FigureCanvasAgg(made[0]).draw()
    return made[0]


def test_legends_lie_outside_of_the_axes_and_inside_the_picture(figure: Figure) -> None:
    legends = [axes.get_legend() for axes in figure.axes]
    boxes = [legend.get_window_extent() for legend in legends if legend is not None]
    assert len(boxes) == 3
    assert not any(box.overlaps(axes.get_window_extent()) for box in boxes for axes in figure.axes)
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert all(box.x1 <= figure.bbox.x1 and box.y0 >= figure.bbox.y0 for box in boxes)


def test_every_axis_has_a_unit_and_every_controller_its_force_over_the_least(figure: Figure) -> None:
    assert all("[" in axes.get_ylabel() for axes in figure.axes[1:])
    assert figure.axes[-1].get_xlabel() == "time [s]"
    names = [text.get_text() for text in figure.axes[1].get_legend().get_texts()]  # type: ignore[union-attr]
    assert sum("times the least" in name for name in names) == 3


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
    assert "grip force against the least that would have held" in figure.get_suptitle()
