"""Places of polar solids in the world, and which of them are drawn."""

import math

import bpy
import numpy as np
import pytest
from blender_luminaires import farthest, shown_places
from mathutils import Euler, Matrix
from photometric_files import write_peaks

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.luminaires import places as luminaire_places
from lumenray.blender_addon.luminaires.solid import make_solid
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.engine.luminaires.distribution import intensity


def perspective(near=0.1, far=1000.0):
    """Return the projection of an eye at the origin that looks along -z, 90 degrees high and wide."""
    matrix = np.zeros((4, 4))
    matrix[0, 0] = matrix[1, 1] = 1.0
    matrix[2, 2:] = (far + near) / (near - far), 2.0 * far * near / (near - far)
    matrix[3, 2] = -1.0
    return matrix


def test_solids_are_the_finer_the_larger_they_are_on_the_screen():
    # At a distance d, 1 m is 500 / d pixels of a region 1000 pixels high.
    centres = [(0, 0, -2), (0, 0, -10), (0, 0, -40), (0, 0, -200), (0, 0, 0.2)]
    sizes = luminaire_places.screen_radius(centres[:4], 1.0, perspective(), 1000)
    assert sizes == pytest.approx([250.0, 50.0, 12.5, 2.5])
    levels = luminaire_places.choose_levels(centres, 1.0, perspective(), 1000)
    assert levels.tolist() == [0, 1, 2, -1, 0]


def test_solids_beside_and_behind_the_view_are_left_out():
    centres = [(0, 0, 5), (20, 0, -10), (0, -20, -10), (10.5, 0, -10)]
    assert luminaire_places.choose_levels(centres, 1.0, perspective(), 1000).tolist() == [
        -1,
        -1,
        -1,
        1,
    ]


def test_only_the_largest_of_very_many_solids_are_drawn():
    centres = np.zeros((500, 3))
    centres[:, 2] = -np.linspace(5.0, 6.0, 500)
    levels = luminaire_places.choose_levels(centres, 1.0, perspective(), 1000)
    assert (levels >= 0).sum() == luminaire_places.MOST_SOLIDS
    assert (levels[: luminaire_places.MOST_SOLIDS] >= 0).all()


def beam(place):
    """Direction in the world in which the solid reaches farthest."""
    return place.turn @ farthest(make_solid(place.distribution, 48, 36))


HALF = math.sqrt(0.5)


def test_c0_of_an_upright_luminaire_is_along_the_worlds_x(new_luminaire):
    new_luminaire(write_peaks())
    (place,) = shown_places()
    assert beam(place) == pytest.approx((HALF, 0.0, -HALF), abs=1e-6)


@pytest.mark.parametrize(
    ("changes", "direction"),
    [
        ({"rotation": math.radians(90.0)}, (0.0, HALF, -HALF)),
        ({"rotation": math.radians(30.0)}, (math.cos(math.pi / 6) * HALF, 0.5 * HALF, -HALF)),
    ],
)
def test_settings_turn_the_solid(new_luminaire, changes, direction):
    _, settings = new_luminaire(write_peaks())
    for name, value in changes.items():
        setattr(settings, name, value)
    assert beam(shown_places()[0]) == pytest.approx(direction, abs=1e-6)


def test_c_counted_clockwise_puts_c90_on_the_other_side(new_luminaire):
    _, settings = new_luminaire(write_peaks(peaks=(1, 9, 1, 1, 1)))
    assert beam(shown_places()[0]) == pytest.approx((0.0, HALF, -HALF), abs=1e-6)
    settings.mirror = True
    (place,) = shown_places()
    assert beam(place) == pytest.approx((0.0, -HALF, -HALF), abs=1e-6)
    assert np.linalg.det(place.turn) == pytest.approx(-1.0)


def test_object_turns_moves_and_does_not_stretch_its_solid(new_luminaire):
    turn = Euler((math.radians(90.0), 0.0, 0.0)).to_matrix().to_4x4()
    new_luminaire(write_peaks(), matrix=Matrix.Translation((1, 2, 3)) @ turn @ Matrix.Scale(5.0, 4))
    (place,) = shown_places(scale=0.01)
    # Turned a quarter about x, what shone down shines along +y.
    assert beam(place) == pytest.approx((HALF, HALF, 0.0), abs=1e-6)
    assert place.centre == pytest.approx((1.0, 2.0, 3.0))


RANDOM = Matrix.Translation((1, 2, 3)) @ Euler((0.3, -0.8, 2.0)).to_matrix().to_4x4()

MIRRORED = RANDOM @ Matrix.Diagonal((1.0, -1.0, 1.0, 1.0))


@pytest.mark.parametrize("matrix", [RANDOM, MIRRORED])
@pytest.mark.parametrize("kind", [1, 2, 3])
def test_solid_stands_as_the_engine_is_told(new_luminaire, matrix, kind):
    planes = {"azimuths": (-90, 0, 30, 90), "peaks": (0, 1, 9, 0)} if kind > 1 else {}
    source, settings = new_luminaire(write_peaks(kind=kind, **planes), matrix=matrix)
    settings.rotation, settings.mirror, settings.flip_h = 0.4, True, True
    light = convert_light(
        source, "l", "l", np.array(source.matrix_world), 1.0, 683.0, ConversionReport()
    )
    (place,) = shown_places()
    local = beam(place) @ light.frame[:3, :3]
    reach = intensity(light.distribution, local)
    assert reach == pytest.approx(light.distribution.intensity.max(), rel=1e-6)
    assert place.frame == pytest.approx(light.frame[:3, :3])
    assert place.opening == light.opening


def test_only_selected_luminaires_are_shown_where_the_others_are_not_to_be(new_luminaire):
    first, settings = new_luminaire(write_peaks())
    new_luminaire(write_peaks(), kind="EMPTY")
    assert len(shown_places()) == 2
    settings.show_solid = False
    assert len(shown_places()) == 1
    first.select_set(True)
    assert len(shown_places()) == 2
    first.hide_viewport = True
    assert len(shown_places()) == 1


def test_lights_without_a_usable_file_are_not_shown(new_luminaire):
    _, settings = new_luminaire(write_peaks())
    settings.use_file = False
    assert shown_places() == []
    settings.use_file = True
    settings.text.from_string("IESNA:LM-63-2002\nTILT=NONE\n1 2 3\n")
    assert shown_places() == []


def test_instance_of_a_collection_shows_the_luminaires_in_it(new_luminaire):
    source, _ = new_luminaire(write_peaks(), matrix=Matrix.Translation((0, 0, 1)))
    scene = bpy.context.scene.collection
    group = bpy.data.collections.new("Group")
    group.objects.link(source)
    group.instance_offset = (0, 0, 1)
    for number in range(2):
        instance = bpy.data.objects.new("Instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        instance.location = (3.0 * number, 0, 2)
        scene.objects.link(instance)
    bpy.context.view_layer.update()
    scene.objects.unlink(source)
    places = shown_places()
    assert sorted(tuple(place.centre) for place in places) == [(0, 0, 2), (3, 0, 2)]
