"""The service's page, used as by a person in a Chromium without a window: upload, lux maps, a walk, probes, sliders."""

import json
import os
import re

import bpy
import numpy as np
import page_visits
import pytest

from lumenray.libraries import materials
from lumenray.service.confinement import LEAST_VERSION, landlock_version

CANDELA = 100.0

LAMP = np.array([0.7, 0.4, 1.1])

pytestmark = [
    pytest.mark.skipif(not page_visits.CAN_VISIT, reason=page_visits.HOW),
    pytest.mark.skipif(landlock_version() < LEAST_VERSION, reason="the kernel has no Landlock"),
    pytest.mark.usefixtures("extension"),
]


def save_scene(path):
    """A black floor of 3 m under a lamp of 100 cd that stands where no symmetry hides a mistake."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_plane_add(size=3.0)
    floor = bpy.context.object
    floor.name = "Floor"
    material = bpy.data.materials.new("Black")
    material.lumenray.use_override, material.lumenray.reflectance = True, 0.0
    floor.data.materials.append(material)
    # Beside the floor, below it, where it takes no light from it.
    bpy.ops.mesh.primitive_plane_add(size=0.2, location=(0.0, 0.0, -0.5))
    bpy.context.object.name = "Screen"
    bpy.context.object.data.materials.append(material)
    light = bpy.data.lights.new("Lamp", "POINT")
    light.shadow_soft_size = 0.0
    light.lumenray.use_physical = True
    light.lumenray.quantity, light.lumenray.value = "LUMINOUS_INTENSITY", CANDELA
    light.lumenray.light_group = "Ceiling"
    lamp = bpy.data.objects.new("Lamp", light)
    lamp.location = LAMP
    bpy.context.scene.collection.objects.link(lamp)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


@pytest.fixture(scope="module")
def visit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    save_scene(folder / "lamp.blend")
    request = {
        "file": str(folder / "lamp.blend"),
        "error": 1,
        "density": 12,
        "interval": 10,
        "requirement": "office.writing",
        "material": materials.find_entry("wall_white_matt").title,
        "points": [[0.35, 0.6], [0.5, 0.55], [0.6, 0.75]],
        "pictures": os.environ.get("LUMENRAY_PAGE_PICTURES", str(folder)),
    }
    return json.loads(page_visits.visit("page.mjs", folder, request))


def read(told):
    """Illuminance, its error and the place that a probe tells."""
    text, title = told
    lux, error = re.fullmatch(r"Floor: ([\d.,]+) lx ± (?:at most )?([\d.]+) lx", text).groups()
    place = re.match(r"at (\S+), (\S+), (\S+) m; lumel \d+, \d+ of page 1", title).groups()
    return float(lux.replace(",", "")), float(error), np.array(place, dtype=float)


def expected(place):
    """Of the lamp, by the inverse square and the cosine. [lx]"""
    way = LAMP - place
    return CANDELA * way[2] / np.linalg.norm(way) ** 3


@pytest.mark.parametrize("moment", ["before", "restored", "walked"])
def test_a_probe_tells_what_the_lamp_gives_there(visit, moment):
    for (told,) in visit[moment]:
        lux, error, place = read(told)
        assert abs(place[2]) < 1e-3
        assert np.abs(place[:2]).max() < 1.5
        # A lumel is 0.08 m wide: the value is its mean, the place anywhere in it.
        steps = [np.array([x, y, 0.0]) for x in (-0.09, 0.09) for y in (-0.09, 0.09)]
        corners = [expected(place + step) for step in steps]
        assert min(corners) - 3.0 * error < lux < max(corners) + 3.0 * error
        assert error < 0.05 * lux


def test_sliders_of_groups_change_numbers_at_once(visit):
    assert visit["groups"] == 1
    for (before,), (dimmed,) in zip(visit["before"], visit["dimmed"], strict=True):
        assert read(dimmed)[0] == pytest.approx(0.5 * read(before)[0], rel=2e-3)
        assert "at most" in dimmed[0]
    assert visit["restored"] == visit["before"]


def test_two_designs_are_read_at_the_same_place(visit):
    for before, beside in visit["beside"]:
        (first, error, place), (second, _, other) = read(before), read(beside)
        np.testing.assert_allclose(place, other, atol=2e-3)
        assert second == pytest.approx(0.5 * first, abs=4.0 * error)


def test_nothing_is_loaded_from_elsewhere_and_nothing_complained_of(visit):
    assert visit["outside"] == []
    # The browser itself tells of the one edit that was refused.
    refused = "Failed to load resource: the server responded with a status of 400 (Bad Request)"
    assert visit["complaints"] == [refused]
    # Nothing is wider than its window.
    assert visit["phone"] == [True, True]


def test_rooms_say_which_job_they_are(visit):
    assert visit["titles"] == ["2. bake of lamp.blend", "3. bake of lamp.blend"]


def test_sections_of_two_rooms_say_whose_they_are(visit):
    jobs = ["2. bake of lamp.blend", "3. bake of lamp.blend"]
    sections = visit["panelTitles"][1:]
    assert [title.splitlines()[-1] for title in sections] == jobs * 3
    assert sum(title.startswith("office.writing") for title in sections) == 2


def test_edits_are_kept_and_those_that_are_refused_change_nothing(visit):
    said, kept = visit["edits"]["refused"]
    assert "broken.csv, line 2" in said
    assert kept == "cie LED-B3"
    assert visit["edits"]["shown"] == ["lamp.csv", "2", "0.5", ""]


def test_the_verdicts_of_the_requirement_are_told(visit):
    """Of 28 lx in the mean, where 500 lx are asked for."""
    mean = next(row for row in visit["verdicts"] if "mean" in row)
    assert re.search(r"Floor\s+mean ≥ 500\s+28\.\d \(2[78].*\)\s+not met", mean)


def test_the_table_has_every_surface(visit):
    assert "Floor" in visit["table"]
