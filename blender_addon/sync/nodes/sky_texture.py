"""Blender's Sky Texture in a world: the sky's light by the direction; its sun is a light of its own."""

import numpy as np

from ....engine.photometry.colour import XYZ_TO_REC709
from ....engine.sky.atmosphere import preetham
from ....engine.sky.atmosphere.directions import onto_sphere
from ....engine.sky.atmosphere.scattered_sky import (
    MULTIPLE,
    NISHITA,
    SINGLE,
    ScatteredSky,
    find_colours,
)
from ....imports import loaded_when_used
from .fields import Field, map_fields, rgb
from .graph import find_socket, trace
from .mapping import legacy_matrix

with loaded_when_used():
    from ....engine.sky.atmosphere import hosek_wilkie

SCATTERED = {NISHITA, SINGLE, MULTIPLE}
"""Kinds of the node that have a sun with a disk."""


def show_sky(at, context) -> Field:
    """Return what a Sky Texture shows.

    Parameters
    ----------
    at : Inputs
    context : DirectionContext    Is told of the sky, if it has the disk of a sun; shows the disk that it asks for.
    """
    node, socket = at.node, find_socket(at.node.inputs, "Vector")
    sky = _read_sky(node)
    has_disk = sky is not None and sky.sun_size > 0.0
    before = legacy_matrix(node)
    if has_disk and before is not None:
        at.fail("the texture mapping of the node moves the sun's disk", "the sun is left out")
        has_disk = False
    if has_disk:
        context.skies.add(sky)
    # With the disk Blender takes no vector.
    is_linked = not (sky is not None and node.sun_disc) and trace(socket, at.groups).is_output
    vector = at.field(socket) if is_linked else context.coordinates()
    shows_sun = has_disk and context.shown_sun == sun_of(sky)
    find = _find_scattered(sky, shows_sun) if sky is not None else _find_formula(node)

    def show(vector):
        vector = np.array(rgb(vector), dtype=np.float64)
        if before is not None:
            vector = vector @ before[:3, :3].T + before[:3, 3]
        return find(onto_sphere(vector)).astype(np.float32)

    # What is kept of a node does not tell a sky with its sun from one without.
    return map_fields(show, vector, note=at.note) if shows_sun else at.map(show, vector)


def sun_of(sky: ScatteredSky) -> tuple:
    """Return where the sun of a sky stands and how large it is, as values to compare."""
    return (*np.round(sky.towards_sun, 6).tolist(), round(sky.sun_angle, 7))


def _read_sky(node) -> ScatteredSky | None:
    """Return the settings of a node whose sky is computed by scattering, None of other kinds."""
    if node.sky_type not in SCATTERED:
        return None
    dust = node.aerosol_density if hasattr(node, "aerosol_density") else node.dust_density
    sky = node.sky_type, node.sun_elevation, node.sun_rotation, node.altitude
    amounts = node.air_density, dust, node.ozone_density
    sun = (node.sun_size, node.sun_intensity) if node.sun_disc and node.sun_intensity > 0.0 else ()
    return ScatteredSky(*sky, *amounts, *sun)


def _find_scattered(sky: ScatteredSky, shows_sun: bool):
    return lambda directions: find_colours(sky, directions, shows_sun)


def _find_formula(node):
    sun = np.array(node.sun_direction, dtype=np.float64)
    sun = onto_sphere(sun / max(float(np.linalg.norm(sun)), 1e-30))
    if node.sky_type == "PREETHAM":
        model, numbers = preetham, (sun, node.turbidity)
    else:
        model, numbers = hosek_wilkie, (sun, node.turbidity, node.ground_albedo)
    return lambda directions: np.maximum(
        model.find_light(directions, *numbers) @ XYZ_TO_REC709.T, 0.0
    )
