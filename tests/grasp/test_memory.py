"""The node keeps what its fingers learn, when nothing is held."""

from vegrip.grasp.node import GraspForce
from vegrip.grasp.settings import ControlSettings

MS = 1_000_000


class Memory:
    def __init__(self):
        self.looked, self.kept = [], 0

    def look(self, finger, now):
        self.looked.append((finger, now))

    def keep(self):
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


def test_a_node_that_is_activated_again_does_not_lose_what_it_learned(make_node):
    memory = Memory()
    node = GraspForce("grasp", ("index",), make_node()._make_estimator, ControlSettings(), memory)
    node.configure()
    node.activate()
    node.deactivate()
    node.activate()
    assert memory.kept == 1
