"""A picture of the table of pictures as a texture, for surfaces that are not in the palette and for glowing ones."""

import drjit as dr
import mitsuba as mi

from ..arrays import upload


def picture_class():
    """Return the plug-in for the active Mitsuba variant."""

    class Picture(mi.Texture):
        """Looks one row up; which one is data, so that all pictures are one model."""

        def __init__(self, props):
            mi.Texture.__init__(self, props)
            self.table = self.row = None

        def lay(self, table, row):
            """Show a row of a `PictureTable`, which has to be committed before it is looked up."""
            self.table = table
            self.row = upload(mi.UInt32, [row])
            dr.eval(self.row)

        def traverse(self, callback):
            callback.put("row", self.row, mi.ParamFlags.NonDifferentiable)

        def eval(self, si, active=True):
            return mi.Spectrum(self.table.eval(si.uv, si.wavelengths, self.row, mi.Bool(active)))

        def eval_1(self, si, active=True):
            return self.table.eval_1(si.uv, self.row, mi.Bool(active))

        def is_spatially_varying(self):
            return True

        def to_string(self):
            return "Picture[]"

    return Picture
