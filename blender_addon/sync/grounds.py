"""Ground and photo of Blender's world as those of the engine's, and the plane that shows the shadows."""

import math
from dataclasses import replace

import numpy as np

from ...engine.scene.light import Ground, Photo, UniformWorld
from ...engine.scene.material import Black, Material
from ...engine.scene.mesh import Geometry, Placement
from ...engine.scene.scene import content_digest
from ...engine.scene.texture import ImageTexture
from ..foundation.exposure import white_luminance
from ..foundation.report import ConversionReport
from ..foundation.units import metres_per_unit
from .camera import FilmPart, convert_camera, film_size

GEOMETRY, MATERIAL, PLANE = "geometry:ground", "material:ground", "ground"
"""Ids of the disk that the ground is, of what it is made of, and of itself."""

SIDES = 96
"""Of the disk."""

WHITE = 200.0
"""What white in a photo stands for where neither it nor the film says so. [cd/m2]"""


def follows_camera(world) -> bool:
    """Tell whether a world, or None, depends on the scene's camera."""
    return world is not None and world.lumenray.ground.photo == "CAMERA"


def camera_of(depsgraph):
    """Return the scene's camera with all of its film as the engine's, None without a perspective one."""
    scene = depsgraph.scene
    if scene.camera is None or scene.camera.type != "CAMERA" or scene.camera.data.type != "PERSP":
        return None
    source = scene.camera.evaluated_get(depsgraph)
    part = FilmPart(*film_size(scene.render))
    return convert_camera(source, scene, metres_per_unit(scene), ConversionReport(), part)


def camera_state(depsgraph) -> bytes:
    """Return what a world with the camera's photo follows: the camera, its photo and the film's white."""
    camera, scene = camera_of(depsgraph), depsgraph.scene
    shown = "" if camera is None else repr([_state_of(each) for each in _backgrounds(scene)])
    digest = b"" if camera is None else content_digest(camera)
    return digest + shown.encode() + repr(white_luminance(scene.lumenray)).encode()


def photos_of(world, scene) -> frozenset[int]:
    """Session uids of the images that may be the photo of a world, or None."""
    if world is None or world.lumenray.ground.photo == "NONE":
        return frozenset()
    if world.lumenray.ground.photo == "PLATE":
        images = [world.lumenray.ground.plate]
    else:
        has_camera = scene.camera is not None and scene.camera.type == "CAMERA"
        images = [each.image for each in _backgrounds(scene)] if has_camera else []
    return frozenset(image.session_uid for image in images if image is not None)


def _state_of(entry) -> tuple:
    image = entry.image
    name = None if image is None else (image.session_uid, image.filepath, *image.size)
    return (name, entry.frame_method, entry.scale, tuple(entry.offset), entry.rotation)


def project_world(made, world, depsgraph, images, report):
    """Lay a world of the engine on its ground, and put a photo before it.

    Parameters
    ----------
    made : World or None    As converted, with what the camera sees of it; None: black.
    world : bpy.types.World    Evaluated.
    images : ImageCache
    report : ConversionReport

    Returns
    -------
    World or None
    """
    settings = world.lumenray.ground
    ground = _ground_of(world, depsgraph, report)
    photo, is_all = None, settings.photo == "CAMERA"
    if settings.photo != "NONE":
        make = _photo_of_camera if is_all else _plate
        photo = make(world, depsgraph, images, report)
    if ground is None and photo is None:
        return made
    key = "world" if made is None else made.id
    made = UniformWorld(0.0, id=key) if made is None else made
    seen = made.seen or made
    lit = replace(made, ground=ground, photo=photo if is_all else None, seen=None)
    seen = replace(seen, ground=ground, photo=photo, seen=None)
    if content_digest(seen) == content_digest(lit):
        return lit
    return replace(lit, seen=seen)


def plane_of(made) -> tuple:
    """Return the items of the plane that shows the shadows on the ground of a world, or None; () without one."""
    if made is None or made.ground is None:
        return ()
    ground = made.ground
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    corners = np.stack([np.cos(angle), np.sin(angle), np.zeros(SIDES)], axis=1)
    corners = np.concatenate([[[0.0, 0.0, 0.0]], corners])
    number = np.arange(SIDES)
    faces = np.stack([np.zeros(SIDES, int), number + 1, (number + 1) % SIDES + 1], axis=1)
    shape = Geometry(GEOMETRY, corners, faces.astype(np.int32), np.zeros(SIDES, np.int32))
    frame = np.diag([ground.radius, ground.radius, 1.0, 1.0])
    frame[:3, 3] = *ground.centre[:2], ground.level
    plane = Placement(
        PLANE,
        "Ground",
        GEOMETRY,
        frame,
        (MATERIAL,),
        meets_light=False,
        is_catcher=True,
    )
    return shape, Material(MATERIAL, "Ground", Black()), plane


def _ground_of(world, depsgraph, report) -> Ground | None:
    settings = world.lumenray.ground
    if not settings.use_ground:
        return None
    scale = metres_per_unit(depsgraph.scene)
    level, radius = settings.level * scale, settings.radius * scale
    centre = np.array([*settings.centre, settings.level + settings.camera_height]) * scale
    if settings.photo == "CAMERA":
        camera = camera_of(depsgraph)
        if camera is None:
            return None
        centre = np.asarray(camera.frame)[:3, 3].copy()
        if centre[2] <= level:
            report.error(
                world.name,
                "the camera of the photo stands below the ground",
                "there is no ground; lower the ground's height, or raise the camera",
            )
            return None
    return Ground(centre, float(level), float(radius))


def _backgrounds(scene) -> list:
    """Background images that the scene's camera shows."""
    data = scene.camera.data
    shown = data.background_images if data.show_background_images else ()
    return [each for each in shown if each.show_background_image]


def _photo_of_camera(world, depsgraph, images, report) -> Photo | None:
    camera = camera_of(depsgraph)
    if camera is None:
        report.error(
            world.name,
            "a photo of the camera needs a perspective camera",
            "there is no photo; make such a camera the scene's active one",
        )
        return None
    entries = [each for each in _backgrounds(depsgraph.scene) if each.source == "IMAGE"]
    entry = next((each for each in entries if each.image is not None), None)
    if entry is None:
        report.error(
            world.name,
            "the camera shows no background image",
            "there is no photo; add one to the camera, and show it",
        )
        return None
    if tuple(entry.offset) != (0.0, 0.0) or entry.rotation != 0.0:
        report.warn(
            world.name,
            "the camera's background image is shifted or turned",
            "it is laid straight over the film",
        )
    picture = _read(entry.image, world, depsgraph, images, report)
    if picture is None:
        return None
    texture, luminance = picture
    height, width = texture.pixels.shape[:2]
    # The film's sides are in pixels of its own aspect.
    ratio = (width / height) / (camera.extent_x / camera.extent_y)
    across, up = 1.0, 1.0
    if entry.frame_method != "STRETCH":
        is_wide = ratio > 1.0
        if is_wide == (entry.frame_method == "FIT"):
            up = 1.0 / ratio
        else:
            across = ratio
    across, up = across * entry.scale, up * entry.scale
    return Photo(
        texture,
        luminance,
        np.asarray(camera.frame)[:3, :3].copy(),
        float(camera.extent_x * across),
        float(camera.extent_y * up),
        float(camera.shift_x),
        float(camera.shift_y),
    )


def _plate(world, depsgraph, images, report) -> Photo | None:
    settings = world.lumenray.ground
    if settings.plate is None:
        report.error(world.name, "the back plate has no image", "there is none; choose one")
        return None
    picture = _read(settings.plate, world, depsgraph, images, report)
    if picture is None:
        return None
    texture, luminance = picture
    height, width = texture.pixels.shape[:2]
    azimuth = settings.plate_azimuth
    backward = -np.array([math.sin(azimuth), math.cos(azimuth), 0.0])
    right = np.array([math.cos(azimuth), -math.sin(azimuth), 0.0])
    frame = np.stack([right, [0.0, 0.0, 1.0], backward], axis=1)
    extent = 2.0 * math.tan(0.5 * settings.plate_angle)
    return Photo(texture, luminance, frame, extent, extent * height / width)


def _read(image, world, depsgraph, images, report) -> tuple[ImageTexture, float] | None:
    """Pixels of a photo, and the luminance of its white; None where it cannot be read."""

    def note(message, remedy):
        report.warn(world.name, message, remedy)

    reading = images.read(image, True, note)
    if reading is None:
        report.miss(
            world.name, f"the photo '{image.name}' cannot be read", "there is no photo", image.name
        )
        return None
    luminance = world.lumenray.ground.photo_luminance
    if luminance <= 0.0:
        luminance = white_luminance(depsgraph.scene.lumenray)
    if luminance is None:
        report.info(
            world.name,
            "the film's white is found from the picture, so that of the photo is not known",
            f"white in it is {WHITE:g} cd/m²; state the white of the photo, or that of the film",
        )
        luminance = WHITE
    return ImageTexture(reading.colour, name=image.name), float(luminance)
