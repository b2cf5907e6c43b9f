"""What was learned of an object is kept by its name, and told to the next grasp of it."""

import errno
import math
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from validation.faults.testbed import Scene
from vegrip import GripController, paper_model
from vegrip.errors import ConfigError
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.known_objects import KnownObjects, ObjectFriction
from vegrip.grip.parameters import GraspParameters
from vegrip.grip.settings import ControlSettings
from vegrip.trials.candidates import demo_parameters, learning_parameters, make_node

GRASP_S = 7.0
LIFTED_S = 1.0


def parameters(folder: Path, name: str) -> GraspParameters:
    base = learning_parameters(demo_parameters())
    grip = replace(base.grip, wanted_margin=0.25)
    return replace(base, grip=grip, friction=replace(base.friction, object=name), learned=str(folder))


def grasp(settings: GraspParameters) -> Scene:
    scene = Scene("hand", parameters=settings)
    scene.run_until(GRASP_S)
    assert scene.node is not None
    scene.node.deactivate()
    scene.node.cleanup()
    return scene


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, Path]:
    """The first grasp of a mug, and the folder that keeps what was learned."""
    folder = tmp_path_factory.mktemp("learned")
    return grasp(parameters(folder, "mug")), folder


def test_an_object_that_was_held_before_is_lifted_with_less_force_and_slips_no_more(
    first: tuple[Scene, Path], tmp_path: Path
) -> None:
    shutil.copytree(first[1], tmp_path / "learned")
    unknown, known = (grasp(parameters(tmp_path / "learned", name)) for name in ("cup", "mug"))
    early = [int(np.searchsorted(scene.course.time, LIFTED_S)) for scene in (unknown, known)]
    forces = [
        float(np.mean(np.asarray(scene.course.force)[at : at + 100]))
        for scene, at in zip((unknown, known), early, strict=True)
    ]
    assert forces[1] < 0.9 * forces[0]
    assert known.hand_node.hand.slips <= unknown.hand_node.hand.slips
    assert not known.hand_node.hand.dropped


def test_the_file_holds_the_friction_of_the_object_within_its_error(first: tuple[Scene, Path]) -> None:
    scene, folder = first
    found = KnownObjects(folder).read("mug")
    assert found is not None
    true = math.log(float(np.mean([tip.friction for tip in scene.hand_node.hand.soft.tips])))
    assert abs(found.mean - true) < 3.0 * found.prior[1]
    assert found.prior[1] == pytest.approx(math.hypot(found.std, 0.1))
    assert KnownObjects(folder).read("cup") is None


def test_a_grasp_that_has_learned_nothing_keeps_nothing(tmp_path: Path) -> None:
    node = make_node(parameters(tmp_path, "mug"), ("thumb", "index"))
    node.configure()
    node.cleanup()
    assert KnownObjects(tmp_path).read("mug") is None


@pytest.mark.parametrize(
    "text", ["", "{}", "[1]", '{"ln_friction": NaN, "std": 0.1}', '{"ln_friction": 0, "std": 0}']
)
def test_a_damaged_file_is_put_aside_and_told(
    text: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    objects = KnownObjects(tmp_path)
    objects.write("mug", ObjectFriction(-0.3, 0.1))
    assert objects.read("mug") == ObjectFriction(-0.3, 0.1)
    (tmp_path / "objects" / "mug.json").write_text(text)
    assert objects.read("mug") is None
    assert "is put aside" in caplog.text
    assert (tmp_path / "objects" / "mug.json.damaged").is_file()


@pytest.mark.parametrize("name", ["../mug", "a/b", "-x", "x" * 65, "a b"])
def test_a_name_that_is_no_name_of_a_file_is_refused(name: str, tmp_path: Path) -> None:
    node = make_node(parameters(tmp_path, name), ("thumb", "index"))
    with pytest.raises(ConfigError, match=r"friction\.object"):
        node.configure()


def test_an_object_without_a_folder_is_refused() -> None:
    settings = replace(parameters(Path(), "mug"), learned="")
    node = make_node(settings, ("thumb", "index"))
    with pytest.raises(ConfigError, match="'learned' names no folder"):
        node.configure()


def test_what_is_written_again_into_a_folder_that_is_there_counts(tmp_path: Path) -> None:
    known = KnownObjects(tmp_path / "objects")
    for mean in (-0.5, -0.7):
        known.write("mug", ObjectFriction(mean, 0.1))
    assert known.read("mug") == ObjectFriction(-0.7, 0.1)


@pytest.mark.parametrize(("mean", "std"), [(50.0, 0.1), (math.nan, 0.1), (-0.5, 0.0), (-0.5, math.inf)])
def test_what_cannot_have_been_learned_is_refused_of_a_known_object(mean: float, std: float) -> None:
    settings = ControlSettings(friction=FrictionSettings(learning=True))
    with pytest.raises(ConfigError, match="what is known of the object is"):
        GripController(
            ("thumb", "index"), paper_model(9e-3), settings=settings,
            known_object=lambda: ObjectFriction(mean, std),
        )  # fmt: skip


@pytest.mark.parametrize(
    ("mean", "std", "is_plausible"),
    [
        (1.99, 0.1, True), (-1.99, 0.1, True), (2.0, 0.1, False), (-2.0, 0.1, False), (0.0, 2.0, True),
        (0.0, 2.001, False), (0.0, 1e-9, True), (0.0, 0.0, False), (0.0, -0.1, False),
        (0.0, math.nan, False), (math.nan, 0.1, False),
    ],
)  # fmt: skip
def test_a_grasp_learns_a_friction_of_less_than_e_to_the_second_either_way(
    mean: float, std: float, is_plausible: bool, tmp_path: Path
) -> None:
    friction = ObjectFriction(mean, std)
    assert friction.is_plausible == is_plausible
    objects = KnownObjects(tmp_path)
    objects.write("mug", friction)
    assert objects.read("mug") == (friction if is_plausible else None)


def test_a_folder_that_cannot_be_written_is_told_and_ends_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "objects").write_text("a file where the folder should be")
    KnownObjects(tmp_path).write("mug", ObjectFriction(-0.3, 0.1))
    (said,) = [one.getMessage() for one in caplog.records]
    file = tmp_path / "objects" / "mug.json"
    why = os.strerror(errno.EEXIST)
    assert said == f"what was learned of mug cannot be written to {file}: {why}"


def test_a_damaged_file_that_cannot_be_put_aside_is_told_twice_and_stays(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / "objects" / "mug.json"
    (tmp_path / "objects" / "mug.json.damaged" / "taken").mkdir(parents=True)
    file.write_text("damaged")
    assert KnownObjects(tmp_path).read("mug") is None
    first, second = [one.getMessage() for one in caplog.records]
    assert first == f"what is known of mug cannot be used, and is put aside as {file}.damaged"
    assert second.startswith(f"{file} cannot be put aside: ")
    assert file.read_text() == "damaged"


@pytest.mark.parametrize("name", ["x" * 64, "0", "A-_9"])
def test_a_name_of_up_to_64_letters_is_one_of_a_file(name: str, tmp_path: Path) -> None:
    KnownObjects(tmp_path).write(name, ObjectFriction(-0.3, 0.1))
    assert [file.name for file in (tmp_path / "objects").iterdir()] == [f"{name}.json"]
    assert KnownObjects(tmp_path).read(name) == ObjectFriction(-0.3, 0.1)
