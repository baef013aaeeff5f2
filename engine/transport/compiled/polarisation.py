"""Polarisation of light between panes and mirrors.

The first pane that light meets shares it out as for unpolarised light, but what it sends on is polarised, and the next pane
treats that otherwise: of two panes at 65 degrees a tenth more passes than the product of their transmittances. Rays carry a
vector across their direction: its line is the axis that holds more light than the one across it, and its length the share
by which, the degree of polarisation. Paths go from the receiver to the light, but the product of the panes' matrices, each
symmetric, is the same both ways for light that is unpolarised where it comes from and received as it is. What spreads light
or refracts it is taken to end its polarisation; plane and curved mirrors keep it.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...materials.polarised_pane import polarised_shares
from ...scene.material import ThinGlass
from ...scene.texture import ImageTexture

MIRROR = -1.0
"""Stands in the table for the refractive index of a mirror; that of all else is 0."""


def make_polarisation(size: int, parts, item, make):
    """What panes and mirrors do to polarisation.

    Parameters
    ----------
    size : int    Of tables by the number of a shape.
    parts : list of bodies.Part
    item : callable    From a material's id to the `Material`.
    make : TextureMaker

    Returns
    -------
    Polarisation or None    None where light meets one flat pane at most, which no polarisation comes to.
    """
    rows, faces, is_polarised = np.zeros((size, 2)), 0, False
    for part in parts:
        surface = item(part.material).surface
        if isinstance(surface, ThinGlass) and surface.is_mirroring_pane:
            rows[part.number] = surface.ior, _mean(surface.transmittance, make)
            is_polarised = True
        elif surface.is_mirror:
            rows[part.number, 0] = MIRROR
        else:
            continue
        faces += 1 if len(part.mirrors) == 1 and (part.planes == 0).all() else 2
    return Polarisation(rows) if is_polarised and faces > 1 else None


def _mean(colour, make) -> float:
    """Transmittance of a pane's body that stands for all wavelengths and places: it matters little here. [-]"""
    if isinstance(colour, ImageTexture):
        return float(np.clip(colour.mean().mean(), 0.0, 1.0))
    return float(make.spectrum(colour, 16).mean())


class Polarisation:
    """Panes and mirrors on the device. ``rows``: refractive index and transmittance of the body, by shape, (n, 2)."""

    def __init__(self, rows: np.ndarray):
        self._rows = upload(mi.Float, rows)
        dr.eval(self._rows)

    def meet(self, si, before, after, polar, is_turned, active):
        """What becomes of light at a surface.

        Parameters
        ----------
        si : SurfaceInteraction3f
        before, after : Vector3f    Directions of the ray.
        polar : Vector3f    Its polarisation, see above.
        is_turned : Bool    Whether it does not go straight on.

        Returns
        -------
        (Float, Vector3f)    By how much more of it goes on than of unpolarised light, and its new polarisation.
        """
        shape = dr.reinterpret_array(mi.UInt32, si.shape)
        ior = dr.gather(mi.Float, self._rows, shape * 2, active)
        body = dr.gather(mi.Float, self._rows, shape * 2 + 1, active)
        is_pane = active & (ior > 0.0)
        cosine = dr.abs(mi.Frame3f.cos_theta(si.wi))
        uneven, mixed = polarised_shares(cosine, dr.select(is_pane, ior, 1.5), body, is_turned)
        uneven, mixed = dr.select(is_pane, uneven, 0.0), dr.select(is_pane, mixed, -1.0)
        # Along the normal every axis is one across the plane of incidence.
        across = dr.cross(before, si.sh_frame.n)
        length = dr.norm(across)
        is_askew = length > 1e-4
        across = dr.select(is_askew, across / dr.maximum(length, 1e-4), mi.Frame3f(before).s)
        beside = dr.cross(before, across)

        degree = dr.norm(polar)
        c, s = dr.dot(polar, across), dr.dot(polar, beside)
        half = 1.0 / dr.maximum(degree, 1e-12)
        q, u = (c * c - s * s) * half, 2.0 * c * s * half
        factor = 1.0 + uneven * q
        q, u = (uneven + q) / dr.maximum(factor, 1e-6), mixed * u / dr.maximum(factor, 1e-6)
        degree = dr.norm(mi.Vector2f(q, u))
        half = 0.5 / dr.maximum(degree, 1e-12)
        c, s = dr.safe_sqrt((degree + q) * half), dr.safe_sqrt((degree - q) * half)
        s = dr.select(u < 0.0, -s, s)
        made = dr.minimum(degree, 1.0) * (across * c + dr.cross(after, across) * s)
        made = dr.select(degree > 1e-6, made, 0.0)

        keeps = is_pane | (is_turned & (ior < 0.0))
        polar = dr.select(keeps, made, dr.select(is_turned, 0.0, polar))
        return dr.select(is_pane, factor, 1.0), mi.Vector3f(polar)


def polarise(scene, si, before, after, polar, is_turned, active):
    """As `Polarisation.meet`, for scenes that may need none."""
    if scene.polarisation is None:
        return mi.Float(1.0), polar
    return scene.polarisation.meet(si, before, after, polar, is_turned, active)
