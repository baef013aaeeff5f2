"""Paints of one or two layers, and directions of the angles by which their readings are stated."""

import numpy as np

from lumenray.engine.paint.reader import parse_paint


def make_paint(layers, reflectance=0.0, **own):
    """A paint of layers (thickness in um, flakes, pigments, binder index)."""
    made = [
        {
            "thickness_um": thickness,
            "binder": {"index": index},
            "flakes": flakes,
            "pigments": pigments,
        }
        for thickness, flakes, pigments, index in layers
    ]
    content = {"lumenray_paint": 1, "name": "Test", "layers": made}
    return parse_paint(content | {"substrate": {"reflectance": reflectance}} | own)


def one_layer(flakes, reflectance=0.0, thickness=20, pigments=(), index=1.45):
    return make_paint([(thickness, list(flakes), list(pigments), index)], reflectance)


def mirrors(reflectance, tilt, area=0.1, **own):
    """Opaque flakes."""
    amount = {"area_per_volume_per_um": area}
    return {"mirror": {"reflectance": reflectance}, "amount": amount, "tilt_deg": tilt} | own


def interference(core, core_index, coating, area, tilt=3, **own):
    """Flakes of a core with titania of the index 2.7 on both faces, thicknesses in nm."""
    stack = {
        "core": {"index": core_index, "thickness_nm": core},
        "coatings": [{"index": 2.7, "thickness_nm": coating}],
    }
    return {"stack": stack, "amount": {"area_per_volume_per_um": area}, "tilt_deg": tilt} | own


def aspecular(angles):
    """Directions of (incidence, aspecular angle towards the source) in degrees: two (n, 3) arrays."""
    incidence, exit_angle = np.radians([(i, i - a) for i, a in angles]).T
    zero = np.zeros_like(incidence)
    wi = np.stack([np.sin(incidence), zero, np.cos(incidence)], axis=1)
    return wi, np.stack([-np.sin(exit_angle), zero, np.cos(exit_angle)], axis=1)


SAMPLE_ANGLES = [(45, 15), (45, 25), (45, 45), (45, 75), (45, 110), (15, 15), (15, 45)]
"""Angles of the reference's table of samples."""

SAMPLES = {
    1: one_layer([interference(448, 1.5, 12, 0.17295053614666203)]),
    2: one_layer([interference(230, 1.77, 165, 0.03721406344946839)], 0.2),
    3: one_layer(
        [
            interference(230, 1.77, 60, 0.017512500446808656, 4),
            interference(300, 1.77, 60, 0.03502500089361731, 4),
        ],
        0.95,
    ),
}
"""The reference's samples, by number."""
