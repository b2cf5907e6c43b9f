"""The node keeps what its fingers learn: when nothing is held, and now and then beside the loop."""

from dataclasses import replace

import pytest

from validation.faults.testbed import Scene
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.estimator.learning import Learned, fingerprint
from vegrip.grip import learned_store
from vegrip.grip.learned_store import InMemory, OnDisk
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import estimator_factory, learned_store_of
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Estimate, LearnedParameter
from vegrip.model import paper_model
from vegrip.trials.candidates import demo_parameters

MS = 1_000_000


class Memory:
    def __init__(self):
        self.looked, self.kept = [], 0

    def observe(self, finger, now):
        self.looked.append((finger, now))
        raw = Estimate(1.3, 0.2, True, 0.01)
        return {"K": Learned(raw, 1.2, valid=False, excited=2.5)}

    def save(self):
        self.kept += 1


def test_it_looks_at_the_pace_of_the_health_reports_and_keeps_at_the_end(make_node, state):
    memory, settings = Memory(), ControlSettings()
    make_estimator = make_node()._make_estimator
    node = GraspForce("grasp", ("index",), make_estimator, settings, memory)
    node.configure()
    node.activate()
    memory.looked.clear()
    for i in range(1000):
        list(node.on_message(state(i), i * 2 * MS))
    assert len(memory.looked) == 10, "2 s at 500 Hz, health every 0.2 s"
    assert memory.kept == 0, "no file is written while a finger holds"
    node.deactivate()
    assert memory.kept == 0
    node.cleanup()
    assert memory.kept == 1


def test_it_tells_what_is_learned_once_a_second(make_node, state):
    node = GraspForce("grasp", ("index",), make_node()._make_estimator, ControlSettings(), Memory())
    node.configure()
    node.activate()
    told = []
    for i in range(2000):
        told += [m for m in node.on_message(state(i), i * 2 * MS) if isinstance(m, LearnedParameter)]
    assert [m.seq for m in told] == [0, 1, 2, 3]
    assert {(m.symbol, m.raw.value, m.filtered.value, m.filtered.valid, m.excited) for m in told} == {
        ("K", 1.3, 1.2, False, 2.5)
    }


def test_without_a_folder_it_still_watches():
    model, memory = paper_model(8e-3), InMemory()
    memory.estimator("index", model, SensorNoise(), EstimatorSettings())
    assert set(memory.observe("index", 0)) == set(memory.learners["index"].symbols)
    assert memory.observe("thumb", 0) == {}


def test_a_node_that_is_activated_again_does_not_lose_what_it_learned(make_node):
    memory = Memory()
    node = GraspForce("grasp", ("index",), make_node()._make_estimator, ControlSettings(), memory)
    node.configure()
    node.activate()
    node.deactivate()
    node.activate()
    assert memory.kept == 1


def settled(folder):
    """Return a pinch that holds its object, with a node that keeps what it learns in ``folder``."""
    scene = Scene()
    scene.simulation.kill(scene.grip)
    scene.grip = scene.simulation.add(remembering(folder, scene.fingers), scene.endpoint(), scene.loop)
    return scene


def remembering(folder, fingers):
    settings = replace(demo_parameters(), learned=str(folder))
    settings = replace(settings, tips={"thumb": settings.tips["thumb"]})
    memory = learned_store_of(settings)
    make = estimator_factory(settings, tuple(fingers), "grasp_force", memory)
    node = GraspForce("grasp_force", tuple(fingers), make, settings, memory)
    node.memory = memory
    return node


def worst_margin(node):
    return min(finger.estimator.slip_margin().lower_bound for finger in node.fingers.values())


def test_a_node_that_is_killed_while_holding_knows_afterwards_what_it_had_learned(tmp_path):
    """Kill -9 has no end at which to keep anything: it was written before, and the margin is no worse."""
    scene = settled(tmp_path)
    node = scene.grip.node
    scene.run_until(12.0)
    node.memory.writing.join()
    files = sorted(path.name.partition("-")[0] for path in tmp_path.glob("*.json"))
    assert files == ["index", "thumb"]
    stiffness = {f: finger.estimator.value("K").value for f, finger in node.fingers.items()}
    margin = worst_margin(node)
    scene.simulation.kill(scene.grip)
    scene.run_until(13.0)
    again = remembering(tmp_path, scene.fingers)
    scene.simulation.add(again, scene.endpoint(), scene.loop)
    for name, finger in again.fingers.items():
        prior = finger.estimator.model.values["K"]
        assert prior.value == pytest.approx(stiffness[name], rel=0.05)
    scene.run_until(14.0)
    assert scene.hand_node.hand.slips == 0
    assert worst_margin(again) > min(margin, again.parameters.grip.wanted_margin) - 0.02


def test_a_folder_that_cannot_be_written_is_told_and_nothing_else(tmp_path, caplog):
    (tmp_path / "file").write_text("")
    scene = settled(tmp_path / "file" / "folder")
    scene.run_until(12.0)
    scene.grip.node.memory.writing.join()
    assert "cannot be written" in caplog.text


def test_it_is_written_every_ten_seconds_one_writing_at_a_time(tmp_path, monkeypatch):
    alive = []

    class Task:
        def __init__(self, _):
            alive.append(True)

        def start(self):
            written.append(now)

        def is_alive(self):
            return alive[-1]

    monkeypatch.setattr(learned_store, "SideTask", Task)
    memory, written = OnDisk(tmp_path), []
    for now in (5.0, 14.999, 15.0, 16.0, 25.0, 26.0):
        assert memory.observe("index", round(now * 1000) * MS) == {}
    assert written == [15.0]
    alive[-1] = False
    for now in (27.0, 36.999, 37.0):
        memory.observe("index", round(now * 1000) * MS)
        alive[-1] = False
    for now in (3.0, 12.999, 13.0):  # the clock was set back
        memory.observe("index", round(now * 1000) * MS)
    assert written == [15.0, 27.0, 37.0, 13.0]


WHOLE = (
    '{"version": 1, "fingerprint": "%s", "parameters": {"mu": {"value": 0.8, "std": 0.1, "excited": 20.0}}}'
)
DAMAGED = {
    "value out of bounds": WHOLE.replace("0.8", "64.6"),
    "cut": WHOLE[:60],
    "empty": "",
    "not text": "\x00\xff",
    "another model": WHOLE.replace("%s", "0" * 16),
    "another version": WHOLE.replace("1,", "2,", 1),
    "no such parameter": WHOLE.replace("mu", "nu"),
    "deep": "[" * 100_000,
    "a list": "[]",
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_file_is_told_put_aside_and_done_without(damage, tmp_path, caplog):
    model = paper_model(8e-3)
    memory = OnDisk(tmp_path)
    path = memory._file("index", model)
    path.write_text(WHOLE % fingerprint(model))
    assert memory._known("index", model).values["mu"].value == 0.8, "it is good before it is damaged"
    path.write_text(DAMAGED[damage].replace("%s", fingerprint(model)))
    assert memory._known("index", model) is model
    assert "index begins anew, and what it had learned is put aside as" in caplog.text
    assert "; delete" not in caplog.text
    if damage == "value out of bounds":
        assert "mu is 64.6 +- 0.1, not within" in caplog.text
    assert [each.name for each in tmp_path.iterdir()] == [f"{path.name}.damaged"]
    assert memory._known("index", model) is model
