"""Closed furnace, integrating box and radiosity: interreflection against closed forms and an independent solution."""

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import AreaLight, Output, PointLight, Quantity, UniformWorld
from lumenray.engine.scene.material import Coated, Diffuse, Emission, Glossy, Material, Mix
from lumenray.engine.scene.spectrum import Constant, Rgb

PLACES = np.array([[1.0, 1.0, 0.0], [0.3, 0.2, 0.0], [0.9, 0.2, 1.0]])
UP = np.tile([0.0, 0.0, 1.0], (3, 1))


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("reflectance", [0.5, 0.9])
def test_a_closed_furnace_is_filled_with_the_geometric_series(transport, reflectance):
    # Every wall emits L and reflects rho: everywhere L / (1 - rho), so E = pi L / (1 - rho).
    walls = paint(reflectance, emission=Emission(Constant(1.0), 100.0))
    made = session_of(box(2.0, 2.0, 2.0), walls).measure(
        PLACES, UP, StopRule(samples=1 << 18), seed=1, transport=transport
    )
    expected = np.pi * 100.0 / (1.0 - reflectance)
    assert (made.standard_error < 0.01 * expected).all()
    assert (np.abs(made.illuminance - expected) < 3.0 * made.standard_error).all(), made


def test_a_white_coated_sphere_in_a_uniform_sky_gains_no_energy():
    # A convex body under a uniform sky: no surface may look brighter than the sky (second law).
    sky = UniformWorld(100.0)
    for roughness in (0.05, 0.3, 1.0):
        coat = Material("c", "c", Coated(Constant(1.0), 1.5, roughness))
        floor = quad("f", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "c")
        made = session_of(floor, coat, sky).render(*_camera_down())
        luminance = made.tristimulus[..., 1].mean()
        assert luminance < 100.0 * 1.003
        assert luminance > 100.0 * 0.93, "the coat loses more than single scattering explains"


def _camera_down():
    from lumenray.engine.scene.camera import Camera, Projection
    from lumenray.engine.views import ViewSettings

    frame = np.eye(4)
    frame[2, 3] = 1.0
    camera = Camera(frame, Projection.ORTHOGRAPHIC, 32, 32, 0.5, 0.5)
    return camera, ViewSettings(StopRule(samples=256))


@pytest.mark.slow
def test_flux_is_conserved_in_a_closed_box_with_any_material():
    # Absorbed = emitted: the sum over all walls of E (1 - rho) A is the lamp's flux, whatever reflects how.
    flux = 1000.0
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, flux), np.array([1.0, 1.1, 0.9]))
    rng = np.random.default_rng(2)
    count = 2000
    side = rng.integers(0, 6, count)
    axis, far = side // 2, side % 2
    places = 2.0 * rng.random((count, 3))
    places[np.arange(count), axis] = 2.0 * far
    normals = np.zeros((count, 3))
    normals[np.arange(count), axis] = 1.0 - 2.0 * far
    for surface in (
        Diffuse(Constant(0.7)),
        Mix(Diffuse(Constant(0.4)), Diffuse(Constant(1.0)), 0.5),
    ):
        made = session_of(box(2, 2, 2), Material("paint", "paint", surface), lamp).measure(
            places, normals, StopRule(samples=2048), seed=4
        )
        absorbed = made.illuminance.mean() * 24.0 * 0.3
        error = made.illuminance.std() / np.sqrt(count) * 24.0 * 0.3
        assert abs(absorbed - flux) < 3.0 * error
        assert error < 0.01 * flux


def radiosity(size, light_face_luminance, reflectance, n=12):
    """Mean illuminance of the floor of a closed room with an evenly bright ceiling, by a matrix of patches.

    Independent of the engine: patches of n x n per face, form factors by the differential formula with 4 x 4 sub-patches,
    rows normalised to 1 because the room is closed.
    """
    points, normals, areas, faces = [], [], [], []
    for face in range(6):
        axis, far = face // 2, face % 2
        others = [a for a in range(3) if a != axis]
        for i in range(n):
            for j in range(n):
                p = np.zeros(3)
                p[axis] = size[axis] * far
                p[others[0]] = size[others[0]] * (i + 0.5) / n
                p[others[1]] = size[others[1]] * (j + 0.5) / n
                normal = np.zeros(3)
                normal[axis] = 1.0 - 2.0 * far
                points.append(p)
                normals.append(normal)
                areas.append(size[others[0]] * size[others[1]] / n**2)
                faces.append(face)
    points, normals, areas, faces = map(np.array, (points, normals, areas, faces))
    factors = np.zeros((len(points), len(points)))
    shift = (np.arange(4) + 0.5) / 4 - 0.5
    for du in shift:
        for dv in shift:
            moved = points.copy()
            for face in range(6):
                others = [a for a in range(3) if a != face // 2]
                moved[faces == face, others[0]] += du * size[others[0]] / n
                moved[faces == face, others[1]] += dv * size[others[1]] / n
            away = moved[None] - points[:, None]
            squared = np.maximum((away**2).sum(axis=2), 1e-12)
            cos_i = np.maximum(np.einsum("ijx,ix->ij", away, normals), 0.0)
            cos_j = np.maximum(-np.einsum("ijx,jx->ij", away, normals), 0.0)
            factors += cos_i * cos_j / (np.pi * squared**2) * areas[None] / 16.0
    factors /= factors.sum(axis=1, keepdims=True)
    emitted = np.where(faces == 5, np.pi * light_face_luminance, 0.0)
    rho = np.where(faces == 5, 0.0, reflectance)
    exitance = np.linalg.solve(np.eye(len(points)) - rho[:, None] * factors, emitted)
    return (factors @ exitance)[faces == 4].mean()


@pytest.mark.slow
def test_a_rectangular_room_agrees_with_radiosity(transport):
    size, reflectance, luminance = (4.0, 3.0, 2.5), 0.6, 500.0
    expected = radiosity(size, luminance, reflectance)
    frame = np.eye(4)
    frame[:3, 3] = (2.0, 1.5, 2.4999)
    ceiling = AreaLight(
        "c", "c", Output(Quantity.LUMINANCE, luminance), frame, 4.0, 3.0, visible_to_camera=False
    )
    # Light passes the bodies of lights, so the ceiling behind it is made black.
    room = box(*size)
    slots = np.array(
        [1 if (room.vertices[t, 2] > 2.4).all() else 0 for t in room.triangles], np.int32
    )
    from dataclasses import replace

    room = replace(room, materials=("paint", "black"), material_index=slots)
    grid = (np.arange(20) + 0.5) / 20
    x, y = np.meshgrid(grid * 4.0, grid * 3.0)
    places = np.stack([x.ravel(), y.ravel(), np.zeros(400)], axis=1)
    made = session_of(room, paint(reflectance), paint(0.0, "black"), ceiling).measure(
        places, np.tile([0, 0, 1.0], (400, 1)), StopRule(samples=2048), transport=transport
    )
    error = np.sqrt((made.standard_error**2).mean() / 400)
    assert error < 0.002 * expected
    # The radiosity solution itself is not exact with these patches.
    assert abs(made.illuminance.mean() - expected) < 3.0 * error + 0.002 * expected


def test_light_of_several_lamps_adds_up():
    room, walls = box(3, 3, 3), paint(0.5)
    lamps = [
        PointLight(
            "a", "a", Output(Quantity.LUMINOUS_FLUX, 500.0, Rgb(1, 0.5, 0.2)), np.array([1, 1, 2.0])
        ),
        PointLight("b", "b", Output(Quantity.LUMINOUS_FLUX, 800.0), np.array([2, 2, 1.0]), 0.1),
    ]
    rule = StopRule(samples=1 << 16)

    def read(*chosen):
        return session_of(room, walls, *chosen).measure(PLACES, UP, rule, transport="spectral")

    both, first, second = read(*lamps), read(lamps[0]), read(lamps[1])
    total = first.illuminance + second.illuminance
    error = np.sqrt(both.standard_error**2 + first.standard_error**2 + second.standard_error**2)
    assert (np.abs(both.illuminance - total) < 3.5 * error).all()


def test_spectral_and_photometric_transport_agree_in_a_neutral_scene():
    items = [
        box(3, 3, 3),
        Material("paint", "paint", Mix(Diffuse(Constant(0.5)), Glossy(Constant(0.6), 0.4), 0.3)),
        PointLight("a", "a", Output(Quantity.LUMINOUS_FLUX, 500.0), np.array([1, 1, 2.0]), 0.05),
    ]
    rule = StopRule(samples=1 << 16)
    a = session_of(*items).measure(PLACES, UP, rule, transport="mono")
    b = session_of(*items).measure(PLACES, UP, rule, seed=9, transport="spectral")
    error = np.hypot(a.standard_error, b.standard_error)
    assert (np.abs(a.illuminance - b.illuminance) < 3.5 * error).all()
