"""What closed surfaces hide: left out where nothing that is wanted could tell, and kept wherever it might."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.decision import Asked, boxes_of, places_of
from lumenray.engine.requirements.hulls import INSIDE, OUTSIDE, UNKNOWN, closed_parts, sides
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.material import Cauchy, Dielectric, Diffuse, Material, Mix, Transparent
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta

FLUX = Output(Quantity.LUMINOUS_FLUX, 1000.0)

INDOORS = Asked(None, False, places=boxes_of([[1.0, 1.0, 0.8]]))


def room(name="room", corner=(0.0, 0.0, 0.0), size=(3.0, 2.0, 2.5), material="paint"):
    """A closed box that looks inwards."""
    made = box(*size, material)
    return replace(made, id=name, name=name, vertices=made.vertices + np.array(corner))


def lamp(place, name="lamp"):
    return PointLight(name, name, FLUX, np.array(place), 0.02)


INSIDE_LAMP, OUTSIDE_LAMP = lamp((1.5, 1.0, 2.0), "inside"), lamp((8.0, 1.0, 2.0), "outside")

NEXT_DOOR = room("next door", (3.5, 0.0, 0.0))

OUTDOORS = (
    OUTSIDE_LAMP,
    NEXT_DOOR,
    lamp((5.0, 1.0, 2.0), "next lamp"),
    UniformWorld(1000.0),
    SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 5e4), np.array([0.3, 0.2, -1.0])),
)


def hidden(asked, *items):
    scene = Scene()
    scene.apply(SceneDelta(changed=items))
    plan = make_plan(scene, asked)
    decision = next(each for each in plan.decisions if each.name == "unseen")
    assert decision.bound == 0.0
    return set(plan.changes)


def without(mesh, triangle):
    """A mesh that lacks a triangle."""
    kept = np.arange(len(mesh.triangles)) != triangle
    return replace(mesh, triangles=mesh.triangles[kept], material_index=mesh.material_index[kept])


def test_a_closed_room_hides_everything_outside():
    found = hidden(INDOORS, room(), paint(0.7), INSIDE_LAMP, *OUTDOORS)
    assert found == {"outside", "next door", "next lamp", "world", "sun"}
    camera = Camera(np.eye(4) + np.eye(4, k=3), Projection.PERSPECTIVE, 4, 4)
    camera = replace(
        camera, frame=np.array([[1, 0, 0, 1.0], [0, 1, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]])
    )
    pictured = Asked(0.01, places=places_of(camera))
    assert hidden(pictured, room(), paint(0.7), INSIDE_LAMP, *OUTDOORS) == found


def test_a_closed_body_hides_what_is_in_it():
    """A machine whose inside nobody looks at, with a lamp that is on, on an axis that is not the world's."""
    turn = np.eye(4)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    made = box(1.0, 1.0, 1.0, inwards=False)
    geometry = Geometry("cube", made.vertices, made.triangles, np.zeros(12, np.int32))
    machine = Placement("machine", "machine", "cube", turn, ("paint",))
    cog = replace(machine, id="cog", frame=turn @ np.diag([0.2, 0.2, 0.2, 1.0]))
    cog.frame[:3, 3] = [0.0, 0.6, 0.4]
    items = (
        geometry,
        machine,
        cog,
        paint(0.5),
        lamp((0.0, 0.8, 0.8)),
        lamp((3.0, 3.0, 3.0), "other"),
    )
    aside = Asked(None, False, places=boxes_of([[2.0, 2.0, 0.0], [-1.0, 0.0, 0.0]]))
    assert hidden(aside, *items) == {"cog", "lamp"}
    # Unless a sensor is in it, or somebody wants to know of the cog.
    assert hidden(replace(aside, places=boxes_of([[2.0, 2, 0], [0.0, 0.9, 0.5]])), *items) == set()
    assert hidden(replace(aside, objects=frozenset({"cog"})), *items) == set()
    assert hidden(replace(aside, places=boxes_of([[0.0, 0.9, 0.5]])), *items) == {"other"}


def keyholed():
    made = room()
    # A triangle in place of which there are three, with a hole of 2 mm in their middle.
    a, b, c = made.triangles[0]
    corners = made.vertices[[a, b, c]]
    middle = corners.mean(axis=0)
    hole = middle + 1e-3 * (corners - middle) / np.linalg.norm(corners - middle, axis=1)[:, None]
    n = len(made.vertices)
    ring = [
        (a, b, n),
        (b, n + 1, n),
        (b, c, n + 1),
        (c, n + 2, n + 1),
        (c, a, n + 2),
        (a, n, n + 2),
    ]
    triangles = np.concatenate([made.triangles[1:], np.array(ring, np.int32)])
    return replace(
        made,
        vertices=np.concatenate([made.vertices, hole]),
        triangles=triangles,
        material_index=np.zeros(len(triangles), np.int32),
    )


GLASS = Material("glass", "glass", Dielectric(Cauchy(1.5)))
NET = Material("net", "net", Mix(Diffuse(), Transparent(), 0.01))
SHEET = Material("sheet", "sheet", Diffuse(transmittance=Diffuse().reflectance))


@pytest.mark.parametrize(
    "items",
    [
        (without(room(), 5),),
        (keyholed(),),
        # One of its triangles is of glass, or a cloth of which a little is open, or lets light through its paper.
        *(
            (
                replace(
                    room(),
                    materials=("paint", each.id),
                    material_index=np.eye(1, 12, 3, np.int32)[0],
                ),
                each,
            )
            for each in (GLASS, NET, SHEET)
        ),
        # What shines reaches through the wall, or is in it.
        (replace(room(), meets_light=False),),
        # A pane that lies on the wall: rays that pass it might pass both.
        (room(), GLASS, room("pane", (3.0, 0.5, 0.5), (0.01, 1.0, 1.0), "glass")),
    ],
)
def test_what_might_let_light_in_hides_nothing(items):
    assert hidden(INDOORS, *items, paint(0.7), INSIDE_LAMP, *OUTDOORS[:1], *OUTDOORS[3:]) == set()


def test_what_is_wanted_anywhere_or_on_both_sides_hides_nothing():
    items = room(), paint(0.7), INSIDE_LAMP, *OUTDOORS[:1], *OUTDOORS[3:]
    assert hidden(Asked(0.01, False), *items) == set()
    both = replace(INDOORS, places=boxes_of([[1.0, 1.0, 0.8], [8.0, 0.0, 0.0]]))
    assert "outside" not in hidden(both, *items)
    # A sensor just below the floor counts as lying on it.
    assert hidden(replace(INDOORS, places=boxes_of([[1.0, 1.0, -5e-5]])), *items) == set()
    # The camera sees no ceiling, though light does.
    assert (
        hidden(
            Asked(0.01, True, places=INDOORS.places),
            replace(room(), visible_to_camera=False),
            *items[1:],
        )
        == set()
    )
    # A shadow catcher in the room shows the sky behind everything.
    catcher = replace(room("stand", (1.0, 1.0, 0.1), (0.3, 0.3, 0.3)), is_catcher=True)
    assert hidden(Asked(0.01, True, places=INDOORS.places), *items, catcher) == {"outside", "sun"}
    off = Modelling((("unseen", Switch.OFF),))
    assert hidden(INDOORS, *items, off) == set()


def test_a_lamp_that_comes_through_the_wall_stays():
    items = room(), paint(0.7), INSIDE_LAMP, lamp((3.01, 1.0, 1.0), "half in"), OUTSIDE_LAMP
    assert hidden(INDOORS, *items) == {"outside"}


def test_sides_of_a_ball_in_a_ball():
    """A shell with a wall has two closed parts; a box within the wall is inside of one and outside of the other."""
    outer, inner = box(4, 4, 4, inwards=False), box(2, 2, 2)
    triangles = np.concatenate([outer.triangles, inner.triangles + len(outer.vertices)])
    shell = replace(
        outer,
        vertices=np.concatenate([outer.vertices, inner.vertices + 1.0]),
        triangles=triangles,
        material_index=np.zeros(24, np.int32),
    )
    parts = sorted(closed_parts(shell), key=np.ptp)
    assert [np.ptp(part) for part in parts] == [2.0, 4.0]
    lows = np.array(
        [[1.5, 1.5, 1.5], [0.2, 0.2, 0.2], [3.1, 2.0, 2.0], [5.0, 5.0, 5.0], [0.5, 0.5, 0.5]]
    )
    highs = lows + np.array([[0.5], [0.1], [0.5], [1.0], [1.0]])
    assert sides(parts[0], lows, highs).tolist() == [INSIDE, OUTSIDE, OUTSIDE, OUTSIDE, UNKNOWN]
    assert sides(parts[1], lows, highs).tolist() == [INSIDE, INSIDE, INSIDE, OUTSIDE, INSIDE]


@pytest.mark.slow
@pytest.mark.mitsuba
def test_the_light_is_that_of_the_whole_scene():
    items = room(), paint(0.7), INSIDE_LAMP, *OUTDOORS
    x, y = (
        each.ravel() for each in np.meshgrid(np.linspace(0.5, 2.5, 8), np.linspace(0.5, 2.0, 8))
    )
    places, up = np.column_stack([x, y, np.full(64, 0.8)]), [[0, 0, 1.0]] * 64
    rule = StopRule(samples=1 << 12)
    less = session_of(*items).measure(places, up, rule, 1)
    full = session_of(*items, Modelling((("unseen", Switch.OFF),))).measure(places, up, rule, 2)
    noise = np.hypot(less.standard_error, full.standard_error)
    # Of 64 with sixteen groups; the whole is known to a tenth of that.
    assert (np.abs(less.illuminance - full.illuminance) < 5.0 * noise).all()
    apart, error = (less.illuminance - full.illuminance).mean(), np.sqrt((noise**2).sum()) / 64
    assert abs(apart) < 3.5 * error
    assert (less.standard_error**2).mean() < 1.2 * (full.standard_error**2).mean()
