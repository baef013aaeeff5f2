"""What will be computed: the panel in all its states, and the operator that fills it."""

import bpy
import pytest
from panels import context, draw

from lumenray.blender_addon.foundation import background_job, engine_process
from lumenray.blender_addon.modelling import asked, job, results
from lumenray.blender_addon.modelling.settings import SWITCHES
from lumenray.blender_addon.modelling.wishes import read_wishes
from lumenray.engine.requirements.decision import Asked, Decision
from lumenray.engine.requirements.plan import DECISIONS, Plan
from lumenray.engine.session import Session

PANEL = "LUMENRAY_PT_modelling"


@pytest.fixture(autouse=True)
def _in_this_process(monkeypatch):
    """Decisions are made by an engine here; that of a process of its own is tested where it is."""
    made = []

    def open_session(name, scene=None):
        session = Session()
        session.close = lambda: made.append(name)
        return session

    monkeypatch.setattr(engine_process, "open_session", open_session)
    yield
    results.forget()
    assert set(made) <= {job.NAME}


@pytest.fixture
def settings():
    own = bpy.context.scene.lumenray
    own.render.stop, own.render.error = "ERROR", 0.01
    return own


def add_room():
    """A coloured plane under a lamp, which needs wavelengths."""
    mesh = bpy.data.meshes.new("Plane")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    paint = bpy.data.materials.new("Red Paint")
    if bpy.app.version < (5, 0, 0):
        paint.use_nodes = True
    paint.node_tree.nodes["Principled BSDF"].inputs[0].default_value = (0.7, 0.1, 0.1, 1.0)
    mesh.materials.append(paint)
    lamp = bpy.data.lights.new("Lamp", "POINT")
    for data in (mesh, lamp):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(data.name, data))


def said(where=None):
    return " ".join(draw(PANEL, where or context()))


def find_out():
    assert bpy.ops.lumenray.explain_modelling() == {"FINISHED"}
    return results.find(bpy.context.scene)


def test_before_anything_is_known_there_are_switches_and_a_button(settings):
    drawn = draw(PANEL, context())
    assert set(SWITCHES.values()) <= set(drawn)
    assert "lumenray.explain_modelling" in drawn
    assert "Pictures are done at an error of 1 %" in " ".join(drawn)
    assert "out of date" not in " ".join(drawn).lower()


def test_drawing_never_converts_the_scene(settings, monkeypatch):
    add_room()
    find_out()

    def refuse(*_):
        raise AssertionError("a panel converts the scene")

    monkeypatch.setattr("lumenray.blender_addon.sync.scene.convert_scene", refuse)
    monkeypatch.setattr(results, "store", refuse)
    assert "Red Paint" in said()


def test_every_decision_is_told_with_its_reason_its_bound_and_the_budget(settings):
    add_room()
    answer = find_out()
    assert [each.name for each in answer.plan.decisions] == list(DECISIONS)
    assert answer.plan.asked.error == pytest.approx(0.01)
    assert answer.plan.asked.has_colour
    text = said()
    for decision in answer.plan.decisions:
        assert decision.choice in text
    assert "Material 'Red Paint' has a reflectance" in text
    assert answer.plan.budget_text.removeprefix("s") in text
    assert "(0.33 % allowed)" in text


def test_bounds_and_savings_are_told_in_per_cent(settings):
    name = next(iter(DECISIONS))
    decision = Decision(name, "something simpler", "it is enough", 0.00244, 0.4)
    plan = Plan(Asked(0.01), (decision,), 0.01 / 3.0, False, False)
    scene = bpy.context.scene
    question, wishes = asked.find_question(scene), read_wishes(settings.modelling)
    answer = results.Answer(plan, question, wishes, results.Watch())
    results.store(results.key_of(scene), answer)
    text = said()
    assert "something simpler" in text
    assert "at most 0.24 %" in text
    assert "about 40 %" in text
    assert "It is enough" in text
    assert "Sampling 0.97 %, simplifications at most 0.24 %" in text


def test_without_an_asked_error_only_what_is_exact_is_said_to_be_simplified(settings):
    settings.render.stop = "SAMPLES"
    assert "only what is exact" in said()
    assert find_out().plan.allowed == 0.0


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda own: setattr(own.modelling, next(iter(SWITCHES.values())), "OFF"), "the switches"),
        (lambda own: setattr(own.render, "error", 0.02), "what is asked for"),
        (lambda own: setattr(own, "transport", "SPECTRAL"), "what is asked for"),
        (lambda own: setattr(bpy.data.objects["Lamp"], "location", (1, 1, 1)), "Lamp"),
    ],
)
def test_what_was_decided_is_told_to_be_out_of_date(settings, change, reason):
    add_room()
    find_out()
    assert "Out of date" not in said()
    change(settings)
    bpy.context.view_layer.update()
    assert f"Out of date, changed since: {reason}" in said()
    find_out()
    assert "Out of date" not in said()


def test_decisions_are_kept_apart_by_what_the_scene_is_computed_for(settings):
    add_room()
    find_out()
    settings.modelling.purpose = "LUX_MAPS"
    settings.bake.use_error, settings.bake.error = True, 0.02
    assert results.find(bpy.context.scene) is None
    assert "Lux maps are done at an error of 2 %" in said()
    plan = find_out().plan
    assert (plan.asked.error, plan.asked.has_colour) == (pytest.approx(0.02), False)
    assert len(plan.asked.objects) == 1
    settings.modelling.purpose = "PICTURE"
    assert "Out of date" not in said()
    settings.modelling.purpose = "SENSORS"
    assert "Illuminance sensors are done at an error of" in said()


def test_a_switch_reaches_the_decision(settings):
    name, key = next(iter(SWITCHES.items()))
    setattr(settings.modelling, key, "OFF")
    decisions = {each.name: each for each in find_out().plan.decisions}
    assert decisions[name].switch.name == "OFF"


def test_while_it_is_looked_at_there_is_no_second_button(settings, monkeypatch):
    monkeypatch.setattr(background_job, "is_running", lambda name: name == job.NAME)
    assert "Esc cancels" in said()
    assert not bpy.ops.lumenray.explain_modelling.poll()
