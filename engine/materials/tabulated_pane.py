"""A clear pane known by a table of its transmittance and reflectance over the angle of incidence."""

import numpy as np

from ..arrays import table_size, upload

BEYOND = 360.0
"""Angle of the entries that fill a table up; no direction has it. [deg]"""


def tabulated_pane_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from .specular import pane_components, sample_pane, specular

    @specular
    class TabulatedPane(mi.BSDF):
        """Mirror reflection and straight transmission by a table, the same at all wavelengths."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.m_components = pane_components()
            self.m_flags = self.m_components[0] | self.m_components[1]

        def set_table(self, angles, transmittance, reflectance):
            """Set the table, (n,) each; angles strictly ascending. [deg]"""
            free = table_size(len(angles) + 1) - len(angles)
            columns = [
                np.pad(column, (0, free), "edge") for column in (angles, transmittance, reflectance)
            ]
            columns[0][-free:] = BEYOND
            self.angles, self.transmittance, self.reflectance = (
                upload(mi.Float, column) for column in columns
            )
            dr.eval(self.angles, self.transmittance, self.reflectance)

        def _shares(self, si, active):
            """Reflectance and transmittance, linear in the angle between the entries."""
            # By both sides of the triangle: an arc cosine is blind to small angles.
            sine = dr.sqrt(dr.square(si.wi.x) + dr.square(si.wi.y))
            angle = dr.rad2deg(dr.atan2(sine, dr.abs(si.wi.z)))
            last = dr.width(self.angles) - 1
            above = dr.binary_search(
                0, last, lambda i: dr.gather(mi.Float, self.angles, i, active) <= angle
            )
            above = dr.maximum(mi.UInt32(above), 1)
            low = dr.gather(mi.Float, self.angles, above - 1, active)
            high = dr.gather(mi.Float, self.angles, above, active)
            place = dr.clip((angle - low) / (high - low), 0.0, 1.0)

            def between(column):
                below = dr.gather(mi.Float, column, above - 1, active)
                return mi.Spectrum(
                    dr.lerp(below, dr.gather(mi.Float, column, above, active), place)
                )

            return between(self.reflectance), between(self.transmittance)

        def sample(self, ctx, si, sample1, sample2, active=True):
            return sample_pane(si, *self._shares(si, active), sample1, active)

        def eval_null_transmission(self, si, active=True):
            return self._shares(si, active)[1]

        def to_string(self):
            return "TabulatedPane[]"

    return TabulatedPane
