"""Switches of a scene on their way to the engine: read, sent once, taken away, and put back."""

import bpy
import pytest
from kept_scenes import KeptScene

from lumenray.blender_addon.modelling.settings import CHOICES, SWITCHES
from lumenray.blender_addon.modelling.wishes import read_wishes, wishing, write_wishes
from lumenray.engine.requirements.plan import DECISIONS
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("empty_file")

FIRST = next(iter(DECISIONS))


@pytest.fixture
def settings():
    return bpy.context.scene.lumenray.modelling


def switch(settings, value, name=FIRST):
    setattr(settings, SWITCHES[name], value)


def test_every_decision_has_a_switch_that_can_do_what_the_engine_can(settings):
    assert SWITCHES.keys() == DECISIONS.keys()
    assert [key for key, *_ in CHOICES] == [each.name for each in Switch]
    for key in SWITCHES.values():
        assert getattr(settings, key) == "AUTO"


def test_settings_of_a_new_file_are_those_that_the_engine_has_anyway(settings):
    assert read_wishes(settings) == Modelling()


@pytest.mark.parametrize("share", [1.0 / 3.0, 0.0, 0.2, 0.123456])
def test_wishes_become_settings_and_settings_become_the_same_wishes(settings, share):
    for number, value in enumerate(Switch):
        names = list(DECISIONS)
        chosen = {names[number % len(names)]: value} if value is not Switch.AUTO else {}
        wishes = Modelling(tuple(chosen.items()), share)
        write_wishes(settings, wishes)
        assert read_wishes(settings) == wishes


def test_wishes_for_a_while_are_taken_back(settings):
    switch(settings, "FORCE")
    before = read_wishes(settings)
    with pytest.raises(KeyError), wishing(settings, Modelling(((FIRST, Switch.OFF),), 0.1)):
        assert read_wishes(settings).of(FIRST) is Switch.OFF
        raise KeyError
    assert read_wishes(settings) == before


def test_wishes_are_sent_when_they_change_and_only_then(settings):
    kept = KeptScene(final=True)
    assert not any(isinstance(item, Modelling) for item in kept.step().delta.changed)
    switch(settings, "OFF")
    step = kept.step()
    assert step.delta.changed == (Modelling(((FIRST, Switch.OFF),)),)
    assert step.stats.changed == "what is simplified"
    assert not step.delta.removed
    switch(settings, "OFF")
    bpy.context.scene.lumenray.efficacy = 200.0
    assert not kept.step().delta
    settings.share_percent = 20.0
    assert kept.step().delta.changed == (Modelling(((FIRST, Switch.OFF),), 0.2),)
    settings.property_unset("share")
    switch(settings, "AUTO")
    step = kept.step()
    assert step.delta.removed == ("modelling",)
    assert kept.scene.modelling == Modelling()
    assert kept.scene.hash() == Scene().hash()


def test_a_view_is_not_told_of_a_share_as_it_asks_for_no_error(settings):
    kept = KeptScene()
    kept.step()
    settings.share_percent = 20.0
    assert not kept.step().delta
    switch(settings, "FORCE")
    assert kept.step().delta.changed == (Modelling(((FIRST, Switch.FORCE),)),)


def test_a_scene_that_is_sent_anew_takes_wishes_away_that_are_no_more(settings):
    kept = KeptScene(final=True)
    switch(settings, "OFF")
    kept.step()
    switch(settings, "AUTO")
    kept.sync.start_over()
    assert "modelling" in kept.step().delta.removed
    assert kept.scene.modelling == Modelling()
