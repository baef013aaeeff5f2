"""What a solid body lets through of the light on its way inside: the law of Beer and Lambert.

A boundary that is met from inside knows the way that led there, whoever follows the light and in which direction. So all
ways of finding light (paths, light tracing, rays over bends) have the same law without a word of it.
"""

import drjit as dr
import mitsuba as mi


class Body:
    """Inside of a solid.

    Parameters
    ----------
    internal : mi.Texture    Transmittance of ``thickness`` of it, without its boundaries.
    thickness : float    [m]
    """

    def __init__(self, internal, thickness: float):
        self.internal = internal
        self.thickness = mi.Float(thickness)
        dr.make_opaque(self.thickness)

    def passed(self, si, active):
        """Share of the light that has come through the body to a point of its boundary; 1 from outside. (Spectrum)"""
        internal = self.internal.eval(si, active)
        is_inside = mi.Frame3f.cos_theta(si.wi) < 0.0
        way = dr.select(is_inside, si.t, 0.0) / self.thickness
        share = dr.exp(dr.log(dr.maximum(internal, 1e-30)) * way)
        return dr.select(is_inside, dr.select(internal > 0.0, share, 0.0), 1.0)


def body_of(props) -> Body | None:
    """Read the body of a plug-in; None: all light passes it."""
    return Body(props["internal"], props["thickness"]) if "internal" in props else None
