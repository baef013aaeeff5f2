"""Blender's spread of area lights: how much less light goes aside than from a Lambertian surface."""

import drjit as dr


def narrow(cosine, tan_spread):
    """Factor on the radiance under an angle to the normal. [-]

    Parameters
    ----------
    cosine : Float    Of that angle.
    tan_spread : Float    Tangent of half of the spread, above 0.
    """
    c = dr.abs(cosine)
    tangent = dr.safe_sqrt(1.0 - c * c) / dr.maximum(c, 1e-6)
    return dr.maximum(1.0 - tangent / tan_spread, 0.0)
