"""MuJoCo's contact nearest to a model, checked against what MuJoCo itself presses and creeps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip import paper_model, write_model
from vegrip.bridges.mujoco_contact import MujocoContact, nearest_contact, nearest_law
from vegrip.bridges.mujoco_plant import MujocoHand
from vegrip.cli import main
from vegrip.trials.closed_loop import GRASPS

HELD_N = 3.0


def held(impratio: float = 10.0, noslip: int = 10, gravity: float = 9.81) -> MujocoHand:
    pinch = GRASPS["pinch"]
    plate = replace(pinch.plate, offset_x=0.0, offset_y=0.0, gravity=gravity)
    hand = MujocoHand(replace(pinch, plate=plate), 0, (), impratio=impratio, noslip=noslip)
    hand.advance(2.0, np.full(2, HELD_N))
    return hand


def contacts(hand: MujocoHand) -> list[MujocoContact]:
    """Return what MuJoCo has in its model of both pads."""
    m, found = hand.model, []
    for name in ("first", "second"):
        pad = m.geom(name)
        inverse = m.body_invweight0[[pad.bodyid[0], m.body("object").id], 0].sum()
        found.append(MujocoContact(tuple(pad.solref), tuple(pad.solimp), tuple(pad.friction), 1.0 / inverse))
    return found


def test_mujoco_presses_at_rest_as_the_equation_says() -> None:
    hand = held(gravity=0.0)
    for number, contact in enumerate(contacts(hand)):
        depth = hand.truths()[number, 1]
        assert contact.force(np.array([depth]))[0] == pytest.approx(HELD_N, rel=1e-3)
        assert hand.contact(number)[0] == pytest.approx(HELD_N, rel=1e-3)


def test_a_held_object_creeps_as_the_equation_says_and_not_with_noslip() -> None:
    hand = held(impratio=100.0, noslip=0)
    depths = hand.truths()[:, 1]
    each = [one.creep(1.0, d, 100.0) for one, d in zip(contacts(hand), depths, strict=True)]
    weight = hand.settings.plate.mass * 9.81
    before = hand.shift
    hand.advance(0.5, np.full(2, HELD_N))
    crept = (hand.shift - before) / 0.5
    # each pad carries half, as its moment about the centre demands; the centre creeps by the mean
    assert crept == pytest.approx(0.5 * weight * sum(each) / 2.0, rel=0.02)
    hand = held()
    before = hand.shift
    hand.advance(0.5, np.full(2, HELD_N))
    assert abs(hand.shift - before) / 0.5 < 0.01 * crept


def test_a_spring_that_mujoco_has_is_found() -> None:
    given = MujocoContact((-2e4, -280.0), (0.3, 0.8, 2e-3, 0.5, 2.0), (0.7, 1e-3, 1e-4), 0.05)
    depths = np.geomspace(2e-4, 2e-3, 16)
    found = nearest_law(depths, given.force(depths), 0.05, given.friction)
    assert found.force(depths) == pytest.approx(given.force(depths), rel=0.01)


def test_what_cannot_be_represented_is_stated_in_numbers() -> None:
    model = paper_model(8e-3).with_value("c1", 0.3).with_value("nu1", 3.0)
    lost = nearest_contact(model, 0.03).misfit
    assert lost.force_lost == pytest.approx(0.3, abs=0.02)  # all of c1 in ten seconds
    assert 0.0 < lost.force_error < 0.1
    assert lost.surface_error == pytest.approx(0.06, abs=0.01)
    assert nearest_contact(model.with_value("c1", 0.0), 0.03).misfit.force_lost < 1e-6


def test_twice_the_mass_needs_half_the_stiffness() -> None:
    model = paper_model(8e-3)
    one, two = (nearest_contact(model, mass).contact for mass in (0.02, 0.04))
    assert one.solref[0] / two.solref[0] == pytest.approx(2.0, rel=0.02)


def test_the_written_file_is_one_that_mujoco_reads(tmp_path, capsys) -> None:
    import mujoco

    model, file = tmp_path / "m.toml", tmp_path / "fingertip.xml"
    write_model(paper_model(8e-3), model)
    assert main(["export", "mujoco", str(model), "-o", str(file)]) == 0
    assert "relaxation: the fingertip loses" in capsys.readouterr().out
    body = '<worldbody><body><freejoint/><geom class="fingertip" size="0.01"/></body></worldbody>'
    read = mujoco.MjModel.from_xml_string(file.read_text().replace("</mujoco>", f"{body}</mujoco>"))
    assert read.geom_condim[0] == 4
    assert math.isfinite(read.geom_solref[0, 0])
    assert read.opt.noslip_iterations > 0


@pytest.mark.parametrize("words", [["--mass", "0"], ["--hold", "-1"]])
def test_a_mass_or_hold_that_cannot_be_is_refused(tmp_path, capsys, words: list[str]) -> None:
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    assert main(["export", "mujoco", str(tmp_path / "m.toml"), *words]) == 2
    assert words[0] in capsys.readouterr().err
