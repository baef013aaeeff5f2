"""Numbers that are none, in every field of everything that comes in, are refused with the names of item and field.

What is owed: one sentence before anything is computed, and a session that goes on as soon as the item is put right or gone.
"""

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.checks import check_item, is_finite
from lumenray.engine.scene.distribution import IntensityDistribution, Opening
from lumenray.engine.scene.light import (
    AreaLight,
    CieSky,
    ImageWorld,
    Luminaire,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import (
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    Glossy,
    IorTable,
    Material,
    Mix,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.scene import Attachment, SceneDelta
from lumenray.engine.scene.sensor import SensorSet
from lumenray.engine.scene.spectrum import Blackbody, Constant, Daylight, Lines, Rgb, Tabulated
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.session import Session
from lumenray.engine.views import Display, LiveSettings, ViewSettings

pytestmark = pytest.mark.mitsuba

FLUX = Output(Quantity.LUMINOUS_FLUX, 100.0)
PLACE, DOWN = np.array([0.5, 0.5, 0.9]), np.array([0.0, 0.0, -1.0])
TABLE = Tabulated(np.array([400.0, 550.0, 700.0]), np.array([0.2, 0.5, 0.4]))
PICTURE = ImageTexture(np.full((2, 2, 3), 0.5, np.float32))
FRAME = np.array([[1.0, 0, 0, 0.5], [0, 1.0, 0, 0.5], [0, 0, 1.0, 0.9], [0, 0, 0, 1.0]])


def with_spectrum(spectrum):
    return PointLight("lamp", "Bulb", replace(FLUX, spectrum=spectrum), PLACE)


def with_surface(surface, **more):
    return Material("paint", "Varnish", surface, **more)


def geometry():
    made = box(1, 1, 1)
    corners = made.vertices[made.triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    return Geometry(
        "shell",
        made.vertices,
        made.triangles,
        made.material_index,
        np.repeat(flat[:, None], 3, axis=1).astype(np.float32),
        {"UV": np.zeros((12, 3, 2), np.float32)},
    )


def mesh():
    made, shape = box(1, 1, 1), geometry()
    return replace(made, name="Room", corner_normals=shape.corner_normals, uv_maps=shape.uv_maps)


DISTRIBUTION = IntensityDistribution(
    np.array([0.0]), np.array([0.0, 0.8, 1.6]), np.array([[3.0, 2.0, 0.0]])
)

ITEMS = {
    "point": PointLight("lamp", "Bulb", FLUX, PLACE, 0.01),
    "spot": SpotLight("lamp", "Bulb", FLUX, PLACE, DOWN, 0.6, 0.1, 0.01),
    "sun": SunLight("lamp", "Bulb", Output(Quantity.ILLUMINANCE, 100.0), DOWN, 0.01),
    "area": AreaLight("lamp", "Bulb", FLUX, FRAME, 0.2, 0.1),
    "luminaire": Luminaire(
        "lamp", "Bulb", FLUX, FRAME, DISTRIBUTION, Opening("rectangle", (0.1, 0.1, 0.0))
    ),
    "light of an RGB colour": with_spectrum(Rgb(0.8, 0.5, 0.2)),
    "light of a table": with_spectrum(TABLE),
    "light of a black body": with_spectrum(Blackbody(3000.0)),
    "light of daylight": with_spectrum(Daylight(6500.0)),
    "light of lines": with_spectrum(Lines(np.array([546.1, 589.3]), np.array([1.0, 2.0]))),
    "light of a constant": with_spectrum(Constant(1.0)),
    "uniform world": UniformWorld(10.0, TABLE),
    "picture world": ImageWorld(PICTURE, 10.0),
    "sky": CieSky(12, np.array([0.1, 0.5, 0.6]), 1e4, 0.2, TABLE),
    "matt": with_surface(Diffuse(Constant(0.5), Constant(0.2))),
    "matt of an RGB colour": with_surface(Diffuse(Rgb(0.1, 0.2, 0.3))),
    "matt of a table": with_surface(Diffuse(TABLE)),
    "matt of a picture": with_surface(Diffuse(PICTURE)),
    "coated": with_surface(Coated(TABLE)),
    "glossy": with_surface(Glossy(Constant(0.5), 0.2)),
    "glossy with a picture": with_surface(Glossy(Constant(0.5), replace(PICTURE, pixels=PICTURE.pixels[..., :1]))),
    "metal": with_surface(Conductor("Al", 0.2)),
    "glass": with_surface(Dielectric(Cauchy(1.5, 0.004), 0.0, TABLE)),
    "rough glass": with_surface(Dielectric(Cauchy(1.5, 0.0), 0.3, Constant(0.9))),
    "glass of a table": with_surface(
        Dielectric(IorTable(np.array([400.0, 700.0]), np.array([1.52, 1.5])))
    ),
    "pane": with_surface(ThinGlass(1.5, TABLE)),
    "pane of a sheet": with_surface(
        TabulatedPane(np.array([0.0, 50.0, 90.0]), np.array([0.8, 0.7, 0.0]), np.array([0.1, 0.1, 1.0]))
    ),
    "opening": with_surface(Transparent(Constant(0.9))),
    "mixture": with_surface(Mix(Diffuse(Constant(0.5)), Glossy(Constant(0.5), 0.2), 0.4)),
    "glow": with_surface(Diffuse(), emission=Emission(TABLE, 10.0, PICTURE)),
    "mesh": mesh(),
    "geometry": geometry(),
    "placement": Placement("box", "Room", "shell", np.eye(4), ("paint",)),
    "sensors": SensorSet("desk", "Desk", np.zeros((3, 3)), np.tile(-DOWN, (3, 1))),
}  # fmt: skip
"""One of each kind, in which every number is to be spoilt."""

NAMES = {PointLight: "Bulb", SpotLight: "Bulb", SunLight: "Bulb", AreaLight: "Bulb",
         Luminaire: "Bulb", Material: "Varnish", Geometry: "shell", SensorSet: "Desk",
         UniformWorld: "the world", ImageWorld: "the world", CieSky: "the world"}  # fmt: skip


def spoilt(value, wrong):
    """Yield the fields that a number lies in and the value with that number spoilt, for each number."""
    if isinstance(value, float):
        yield (), wrong
    elif isinstance(value, np.ndarray) and value.dtype.kind == "f":
        made = value.copy()
        # Neither the first nor the last, where there are more.
        made.flat[value.size // 2] = wrong
        yield (), made
    elif isinstance(value, tuple):
        for i, entry in enumerate(value):
            for path, bad in spoilt(entry, wrong):
                yield path, (*value[:i], bad, *value[i + 1 :])
    elif isinstance(value, dict):
        for key, entry in value.items():
            for path, bad in spoilt(entry, wrong):
                yield path, {**value, key: bad}
    elif is_dataclass(value):
        for entry in fields(value):
            # What infinite pixels of a measured sky count as is decided where the picture is made ready.
            if entry.name == "pixels":
                continue
            for path, bad in spoilt(getattr(value, entry.name), wrong):
                yield (entry.name, *path), replace(value, **{entry.name: bad})


WRONG = {"nan": np.nan, "inf": np.inf, "-inf": -np.inf}


def cases():
    for kind, item in ITEMS.items():
        for word, wrong in WRONG.items():
            for path, bad in spoilt(item, wrong):
                yield pytest.param(bad, path[-1], id=f"{kind}-{'.'.join(path)}-{word}")


def surroundings_of(item):
    """What an item needs to be a part of a scene that is computed."""
    room = {"box": box(1, 1, 1), "paint": paint(0.5), "lamp": ITEMS["point"]}
    if isinstance(item, Geometry):
        room["box"] = ITEMS["placement"]
    if isinstance(item, Placement):
        room["shell"] = ITEMS["geometry"]
    room.pop(item.id, None)
    return list(room.values())


PLACES, NORMALS, RULE = [[0.5, 0.5, 0.2]], [[0.0, 0.0, 1.0]], StopRule(samples=16)


@pytest.mark.parametrize(("item", "field"), list(cases()))
def test_a_number_that_is_none_is_refused_by_name(item, field):
    session = Session(witness=False)
    with pytest.raises(SceneError) as caught:
        session.apply(SceneDelta(changed=(*surroundings_of(item), item)))
        session.measure(PLACES, NORMALS, RULE)
    text = str(caught.value)
    assert NAMES.get(type(item), "Room") in text
    assert field.rstrip("s") in text, text
    assert "\n" not in text
    assert "inf" in text or "nan" in text or "finite" in text


@pytest.mark.parametrize("kind", ITEMS)
def test_whole_items_are_not_refused(kind):
    check_item(ITEMS[kind])


def test_the_rest_of_a_change_is_not_lost_with_its_bad_item():
    # Owed: the very numbers of a scene that never was wrong, once the item is put right or taken away.
    good = [box(1, 1, 1), paint(0.5), ITEMS["point"]]
    expected = session_of(*good).measure(PLACES, NORMALS, RULE).illuminance
    bad = replace(ITEMS["area"], id="other", name="Panel", size_x=np.nan)
    session = session_of(*good, bad)
    for _ in range(2):
        with pytest.raises(SceneError, match="'Panel': size_x is nan"):
            session.measure(PLACES, NORMALS, RULE)
    session.apply(SceneDelta(removed=("other",)))
    np.testing.assert_array_equal(session.measure(PLACES, NORMALS, RULE).illuminance, expected)
    session.apply(SceneDelta(changed=(bad,)))
    with pytest.raises(SceneError, match="'Panel'"):
        session.measure(PLACES, NORMALS, RULE)
    session.apply(SceneDelta(changed=(replace(bad, size_x=0.2, output=replace(FLUX, value=0.0)),)))
    np.testing.assert_array_equal(session.measure(PLACES, NORMALS, RULE).illuminance, expected)


def test_what_is_attached_is_looked_at_too():
    session = session_of(box(1, 1, 1), paint(0.5), ITEMS["point"])
    wrong = Attachment("lamp", {"output": replace(FLUX, value=np.inf)})
    session.apply(SceneDelta(attached=(wrong,)))
    with pytest.raises(SceneError, match=r"light 'Bulb': output\.value is inf"):
        session.measure(PLACES, NORMALS, RULE)
    session.apply(SceneDelta(attached=(Attachment("lamp", {}),)))
    assert session.measure(PLACES, NORMALS, RULE).illuminance[0] > 0.0


def test_the_first_bad_row_of_an_array_is_named():
    item = mesh()
    item.vertices[[3, 6], 1] = np.nan
    with pytest.raises(SceneError, match=r"object 'Room': vertices\[3\] is \[ *0\., +nan"):
        check_item(item)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_numbers_whose_squares_overflow_are_finite(kind):
    large = np.full(1000, 0.9 * np.finfo(kind).max, kind)
    assert is_finite(large)
    assert is_finite(large[::2])
    large[501] = np.inf
    assert not is_finite(large)
    assert not is_finite(large[1::2])
    assert is_finite(np.zeros((0, 3), kind))


# ---- cameras, rules, sensors, probes ----

CAMERA = Camera(FRAME, Projection.PERSPECTIVE, 8, 6, aperture_radius=0.01)
CAMERAS = [
    pytest.param(bad, path[-1], id=f"{'.'.join(path)}-{word}")
    for word, wrong in WRONG.items()
    for path, bad in spoilt(CAMERA, wrong)
]


@pytest.fixture(scope="module")
def room():
    return session_of(box(1, 1, 1), paint(0.5), ITEMS["point"])


@pytest.mark.parametrize(("camera", "field"), CAMERAS)
def test_a_camera_with_a_number_that_is_none_renders_nothing(room, camera, field):
    with pytest.raises(SceneError, match=f"camera: {field}"):
        room.render(camera, ViewSettings(StopRule(samples=2)))


@pytest.mark.parametrize(("camera", "field"), CAMERAS)
def test_a_camera_with_a_number_that_is_none_shows_nothing(room, camera, field):
    try:
        with pytest.raises(SceneError, match=f"camera: {field}"):
            room.watch(camera, LiveSettings(samples=2), Display())
            room.refine()
    finally:
        room.unwatch()


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("field", ["samples", "error", "seconds", "each", "floor", "limits"])
def test_a_rule_with_a_number_that_is_none_is_refused(field, wrong):
    # Such a rule never stops, or at once.
    given = {"samples": 16, field: (1.0, wrong) if field == "limits" else wrong}
    words = {"seconds": "time", "each": "every value", "limits": "limit"}.get(field, field)
    with pytest.raises(SceneError, match=words):
        StopRule(**given)


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("field", ["position", "normal"])
def test_a_sensor_with_a_number_that_is_none_is_told_by_its_place(room, field, wrong):
    positions, normals = np.full((5, 3), 0.5), np.tile([0.0, 0.0, 1.0], (5, 1))
    (positions if field == "position" else normals)[3, 1] = wrong
    with pytest.raises(SceneError, match=f"sensor 4 has a .*{field}"):
        room.measure(positions, normals, RULE)


@pytest.mark.parametrize(
    ("surface", "field"),
    [
        (Diffuse(Constant(np.nan)), "value"),
        (Glossy(Constant(0.5), np.nan), "roughness"),
        (ThinGlass(np.inf), "ior"),
        (Dielectric(Cauchy(np.nan)), "a"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_surface_with_a_number_that_is_none_is_not_probed(surface, field):
    with pytest.raises(SceneError, match=rf"{field} is (nan|inf)"):
        Session(witness=False).probe(surface, [0.0], samples=64)
