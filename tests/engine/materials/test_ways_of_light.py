"""Facets along a direction and fibres: what is found of their light is the same whichever way it is followed."""

import numpy as np
import pytest
from baking_rooms import lamp
from small_scenes import box, paint, quad

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.film import Film
from lumenray.engine.scene.material import Coated, Dielectric, Glossy, Grain, Material, Sheen
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.session import Session
from lumenray.engine.transport import backend
from lumenray.engine.views import ViewSettings

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]

SURFACES = {
    "round": Glossy(Constant(0.8), 0.5, None, Grain(2.5, 0.0, 2)),
    "along U": Glossy(Constant(0.8), 0.5, None, Grain(0.4, 0.1)),
    "brushed paint": Coated(Constant(0.6), 1.8, 0.5, 1.0, 0.0, None, Grain(2.5, 0.1, 0)),
    "paint under a film": Coated(Constant(0.6), 1.5, 0.5, film=Film(420.0, 1.9)),
    "metal under a film": Glossy(Constant(0.7), 0.5, Constant(1.0), film=Film(300.0, 1.5)),
    "glass under a film": Dielectric(roughness=0.5, film=Film(420.0, 1.9)),
    "fibres": Sheen(Coated(Constant(0.4)), 1.0, Constant(0.9), 0.7),
}


@pytest.fixture(autouse=True)
def _mono():
    backend.start(spectral=False)


def room(surface):
    session = Session(witness=True)
    table = quad("table", (0.4, 0.4, 0.5), (1.2, 0, 0), (0, 1.2, 0), "m")
    items = (box(2, 2, 2), table, paint(0.6), Material("m", "m", surface), lamp((0.6, 1.0, 1.7)))
    session.apply(SceneDelta(changed=items))
    return session


@pytest.mark.parametrize("name", SURFACES)
def test_light_paths_from_the_lamp_find_what_gathering_finds(name):
    places = [(1.0, 1.0, 1.2), (1.6, 1.0, 0.9)]
    made = room(SURFACES[name]).measure(places, [(0, 0, -1), (-1, 0, 0)], StopRule(samples=4096))
    assert made.illuminance.min() > 0.0
    assert not [note for note in made.provenance.notes if "light paths from the lights" in note]


@pytest.mark.parametrize("name", SURFACES)
def test_a_picture_is_the_same_with_cells_and_by_full_paths(name):
    frame = np.array([[1, 0, 0, 1.0], [0, 0.8, -0.6, 0.2], [0, 0.6, 0.8, 1.6], [0, 0, 0, 1.0]])
    camera = Camera(frame, Projection.PERSPECTIVE, 8, 8, 1.2, 1.2)
    made = [
        room(SURFACES[name]).render(camera, ViewSettings(StopRule(samples=512), method=method))
        for method in ("paths", "cells")
    ]
    means = [picture.tristimulus[..., 1].mean() for picture in made]
    errors = [np.sqrt((picture.luminance_error**2).sum()) / 64 for picture in made]
    assert means[0] == pytest.approx(means[1], abs=4.0 * np.hypot(*errors) + 2e-3 * means[0])
