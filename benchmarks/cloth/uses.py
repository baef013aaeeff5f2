"""What cloths come to where they are used: data sheets of those that ship, light behind a curtain, a sheen instead."""

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.cloth.surface import WovenSurface
from ...engine.scattering.data.evaluation import totals
from ...engine.scene.light import Output, Quantity, SunLight, UniformWorld
from ...engine.scene.material import Black, Diffuse, Material, Sheen
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant, Illuminant
from ...engine.session import Session
from ...libraries import cloths
from ..common.shapes import make_rectangle

LUMINANCE, SUN = 1000.0, 10_000.0
"""Of the even sky [cd/m2], and illuminance of the sun across its rays. [lx]"""

SIDE, BEHIND = 4.0, 0.01
"""Of the curtain, and how far behind it the map lies, so that it sees next to nothing else. [m]"""

PLACES = 5
"""Of the map along both sides of its square metre."""

SAMPLES = 16_384
"""Of each place."""

SHEEN_ROUGHNESS = 0.5
"""Blender's default."""

ANGLES = np.array([0.0, 30.0, 45.0, 60.0, 70.0, 80.0])
"""At which reflectances are compared. [deg]"""

TURNS = np.radians(np.arange(7.5, 360.0, 15.0))


def compute(preset: str, draft: bool = True) -> WovenSurface:
    """What a cloth that ships scatters, kept from before if it was computed."""
    text = cloths.presets()[preset].read_text(encoding="utf-8")
    # Sessions bring the variant that it takes, whatever was computed before.
    return Session(witness=False).compute_cloth(text, draft)


def light_behind(woven: WovenSurface) -> dict[str, dict[str, float]]:
    """Lux map behind a curtain that closes a black box, under an even sky and under a sun along its normal.

    Returns
    -------
    dict    Of ``sky`` and ``sun``: ``map``, the map's mean over the light in front; ``error``, its standard error;
        ``table``, the transmittance that the tables state; ``table_error``, its standard error, 0 where none is known.
    """
    half, zero = 0.5 * SIDE, (0.0, 0.0, 0.0)
    x, y, z = np.eye(3) * SIDE
    corner = np.array([-half, -half, 0.0])
    things = (
        Material("cloth", "Cloth", woven.surface),
        Material("black", "Black", Black()),
        # Light comes from above onto its front; the box is below it.
        make_rectangle("curtain", corner, x, y, "cloth"),
        make_rectangle("floor", corner - z, x, y, "black"),
        *(
            make_rectangle(f"wall {number}", corner - z + shift, edge, z, "black")
            for number, (shift, edge) in enumerate(((zero, x), (y, x), (zero, y), (x, y)))
        ),
    )
    spectrum = Illuminant("D65")
    lights = {
        "sky": (
            UniformWorld(LUMINANCE, spectrum),
            np.pi * LUMINANCE,
            woven.sheet.diffuse_transmittance,
            0.0,
        ),
        "sun": (
            SunLight(
                "sun",
                "Sun",
                Output(Quantity.ILLUMINANCE, SUN, spectrum),
                np.array([0.0, 0.0, -1.0]),
            ),
            SUN,
            woven.sheet.transmittance,
            woven.sheet.transmittance_error,
        ),
    }
    line = (np.arange(PLACES) + 0.5) / PLACES - 0.5
    places = np.stack([*np.meshgrid(line, line), np.full((PLACES, PLACES), -BEHIND)], axis=-1)
    places = places.reshape(-1, 3)
    made = {}
    for name, (light, arriving, stated, known) in lights.items():
        session = Session(witness=False)
        session.apply(SceneDelta(changed=(*things, light)))
        measured = session.measure(
            places,
            np.tile([0.0, 0.0, 1.0], (len(places), 1)),
            StopRule(samples=SAMPLES),
            method="paths",
        )
        share = measured.illuminance / arriving
        made[name] = {
            "map": float(share.mean()),
            "error": float(np.sqrt((measured.standard_error**2).sum()) / arriving / len(share)),
            "table": stated,
            "table_error": known,
        }
    return made


def sheen_like(woven: WovenSurface, wavelength: float) -> dict:
    """A Lambertian base under a sheen that reflects as much as a cloth, along the normal and of light from everywhere.

    Light that the cloth lets through is left aside, as such a surface lets none through.

    Returns
    -------
    dict    ``base`` and ``weight`` of it; ``angles`` [deg], ``woven`` and ``sheen``: reflectances there; ``diffuse``:
        of light from everywhere, of both; ``error``: the largest standard error of the sheen's.
    """
    table = woven.surface.front_reflection
    band = int(np.argmin(np.abs(table.wavelengths - wavelength)))
    wavelength = float(table.wavelengths[band])
    nodes, weights = np.polynomial.legendre.leggauss(24)
    everywhere = np.arcsin(np.sqrt(0.5 * (nodes + 1.0)))

    def of_cloth(angles):
        return totals(table, angles, TURNS)[..., band].mean(axis=0)

    cloth = of_cloth(np.radians(ANGLES))
    diffuse = float(0.5 * (of_cloth(everywhere) @ weights))
    session = Session(witness=False)

    def probe(surface, angles=None):
        return session.probe(surface, angles, 1 << 15, wavelength=wavelength)

    fibres = Sheen(Black(), roughness=SHEEN_ROUGHNESS)
    normal, even = (float(probe(fibres, each).reflectance[0]) for each in (np.zeros(1), None))
    # Fibres of the weight w reflect w E and let through 1 - w E each way; halving finds w, and the base follows.
    low, high = 0.0, 1.0
    for _ in range(40):
        weight = 0.5 * (low + high)
        base = (cloth[0] - weight * normal) / (1.0 - weight * normal)
        is_low = weight * even + (1.0 - weight * even) * base < diffuse
        low, high = (weight, high) if is_low else (low, weight)
    base = float(max(base, 0.0))
    own = Sheen(Diffuse(Constant(base)), weight=weight, roughness=SHEEN_ROUGHNESS)
    by_angle, all_over = probe(own, ANGLES), probe(own)
    return {
        "wavelength": wavelength,
        "base": base,
        "weight": float(weight),
        "angles": ANGLES.tolist(),
        "woven": cloth.tolist(),
        "sheen": by_angle.reflectance.tolist(),
        "diffuse": [diffuse, float(all_over.reflectance[0])],
        "error": float(by_angle.reflectance_error.max()),
    }
