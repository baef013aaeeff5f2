"""What a pane does to each polarisation, for light that has met others before."""

import drjit as dr


def polarised_shares(cos_theta, ior, internal, is_reflected):
    """Mueller matrix of a plane-parallel pane, about the axis across its plane of incidence, over the unpolarised share.

    Parameters
    ----------
    cos_theta : Float    Cosine to the normal outside. [-]
    ior : Float    Refractive index. [-]
    internal : Float    Transmittance of the glass body at normal incidence, without surface losses. [-]
    is_reflected : Bool    Whether light is reflected, else it passes.

    Returns
    -------
    (Float, Float)    With X for the share of each polarisation: (X_s - X_p) / (X_s + X_p), and what light that is polarised
        between both keeps, as a share of (X_s + X_p) / 2. [-]

    Notes
    -----
    The inner reflections of a pane are added without interference, as in `plugins.pane_optics`.
    """
    cos_i = dr.clip(cos_theta, 1e-4, 1.0)
    cos_t = dr.sqrt(1.0 - (1.0 - cos_i * cos_i) / (ior * ior))
    s = (cos_i - ior * cos_t) / (cos_i + ior * cos_t)
    p = (ior * cos_i - cos_t) / (ior * cos_i + cos_t)
    body = dr.power(dr.maximum(internal, 1e-20), 1.0 / cos_t)

    def shares(r, passing):
        """Shares by a face's reflectance and what passes it, for both polarisations or the product of their amplitudes."""
        inner = passing * body / (1.0 - dr.square(r * body))
        return dr.select(is_reflected, r + r * body * passing * inner, passing * inner)

    r_s, r_p = dr.square(s), dr.square(p)
    x_s, x_p = shares(r_s, 1.0 - r_s), shares(r_p, 1.0 - r_p)
    # Both faces turn the product of the amplitudes alike, since both change sign inside.
    mixed = shares(s * p, dr.sqrt((1.0 - r_s) * (1.0 - r_p)))
    total = dr.maximum(x_s + x_p, 1e-20)
    return (x_s - x_p) / total, 2.0 * mixed / total
