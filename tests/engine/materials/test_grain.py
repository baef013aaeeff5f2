"""Facets that lie along a direction: Mitsuba's own model of them, all light kept, directions round an axis."""

from types import SimpleNamespace

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.scene.material import Coated, Glossy, Grain
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba


@pytest.fixture(autouse=True)
def _mono():
    backend.start(spectral=False)


def plugin(surface):
    import mitsuba as mi

    from lumenray.engine.materials import plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    plugins.register()
    made = bsdf(surface, TextureMaker(np.ones(471)))
    return mi.load_dict(made, optimize=False) if isinstance(made, dict) else made


def seen(theta, phi, count=1):
    """Places that are seen from a direction, by its angle to the normal and its azimuth. [rad]"""
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, count)
    parts = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    si.wi = mi.Vector3f(*map(float, parts))
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    return si


def test_narrow_facets_are_those_of_mitsubas_rough_conductor():
    import mitsuba as mi

    own = plugin(Glossy(Constant(1.0), 0.2, None, Grain(2.0)))
    known = mi.load_dict(
        {"type": "roughconductor", "material": "none", "alpha_u": 0.08, "alpha_v": 0.02,
         "distribution": "ggx"}
    )  # fmt: skip
    rng = np.random.default_rng(1)
    si = seen(0.7, 0.9, 400)
    turn = 0.05 * rng.normal(size=(2, 400))
    wo = np.stack([-np.array(si.wi)[0, 0] + turn[0], -np.array(si.wi)[1, 0] + turn[1]])
    wo = mi.Vector3f(*wo.astype(np.float32), np.sqrt(1.0 - (wo**2).sum(axis=0)).astype(np.float32))
    found, expected = (np.array(each.eval(mi.BSDFContext(), si, wo))[0] for each in (own, known))
    # Mitsuba's shadowing and masking are independent, and facets here pass light on: both are small so narrow.
    assert expected.max() > 5.0
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=0.01)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("stretch", [0.3, 3.0])
@pytest.mark.parametrize("angles", [(0.2, 0.4), (1.2, 0.0), (1.2, 0.8), (1.45, 1.5)])
def test_white_facets_reflect_everything(stretch, angles):
    import mitsuba as mi

    count = 1 << 15
    own = plugin(Glossy(Constant(1.0), 0.6, None, Grain(stretch)))
    stream = mi.PCG32(size=count, initstate=3)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    weight = own.sample(
        mi.BSDFContext(), seen(*angles, count), stream.next_float32(), sample, True
    )[1]
    weight = np.array(weight)[0]
    assert weight.mean() == pytest.approx(1.0, abs=4.0 * weight.std() / np.sqrt(count) + 2e-3)


def test_a_coat_whose_facets_lie_along_nothing_is_the_usual_one():
    import mitsuba as mi

    laid, usual = (
        plugin(Coated(Constant(0.5), 1.6, 0.5, 0.8, 0.0, None, grain)) for grain in (Grain(), None)
    )
    for theta in (0.1, 0.8, 1.4):
        si, wo = seen(theta, 0.3), seen(0.6, 2.8).wi
        found, expected = (np.array(each.eval(mi.BSDFContext(), si, wo)) for each in (laid, usual))
        np.testing.assert_allclose(found, expected, rtol=3e-3)


def test_a_quarter_turn_exchanges_both_widths():
    import mitsuba as mi

    turned, other = (
        plugin(Glossy(Constant(1.0), 0.4, None, grain)) for grain in (Grain(2.0, 0.25), Grain(0.5))
    )
    si, wo = seen(0.7, 0.2), seen(0.5, 2.5).wi
    found, expected = (np.array(each.eval(mi.BSDFContext(), si, wo)) for each in (turned, other))
    # What several facets reflect is of tables by other points.
    np.testing.assert_allclose(found, expected, rtol=1e-3)
    # Behind, the normal that it is turned about is the other one.
    behind, onto = seen(np.pi - 0.7, 0.2), mi.Vector3f(wo.x, wo.y, -wo.z)
    found = np.array(turned.eval(mi.BSDFContext(), behind, onto))
    np.testing.assert_allclose(found, expected, rtol=1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_directions_go_round_the_axes_of_an_object(axis):
    from lumenray.engine.transport.compiled.grain_ways import find_ways

    box = np.array([[0.5, -1.0, 2.0], [1.0, 1.0, 1.0]])
    geometry = Geometry("g", np.zeros((3, 3)), np.zeros((1, 3), int), np.zeros(1, int), box=box)
    angle = 0.6
    frame = np.eye(4)
    frame[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    frame[:3, :3] *= 0.01
    frame[:3, 3] = 3.0, 4.0, 5.0
    item = Placement("o", "Object", "g", frame, ("m",))
    origin = np.array([1.0, 2.0, 3.0])
    body = SimpleNamespace(item=item, geometry=geometry)
    way = find_ways(1, [(body, SimpleNamespace(number=0))], origin)[0, axis]
    place = np.array([0.9, 0.3, 1.1])
    found = way[:3] @ (frame[:3, :3] @ place + frame[:3, 3] - origin - way[3])
    expected = frame[:3, :3] @ np.cross(np.eye(3)[axis], place - box[0])
    np.testing.assert_allclose(
        found / np.linalg.norm(found), expected / np.linalg.norm(expected), atol=1e-9
    )


@pytest.mark.parametrize(
    ("grain", "words"), [(Grain(0.0), "0 times"), (Grain(2.0, axis=3), "axis 3")]
)
def test_what_is_no_direction_is_refused(grain, words):
    for surface in (Glossy(Constant(0.5), 0.5, None, grain), Coated(grain=grain)):
        with pytest.raises(SceneError, match=words):
            plugin(surface)
