"""The plug-in of Mitsuba that stands for all luminaires of a palette."""

import mitsuba as mi

from .palette import LuminairePalette


def make_emitter(palette: LuminairePalette):
    """Make the emitter of a palette.

    It holds the palette and not the other way round: in a cycle Python would free it at a moment of its own, perhaps while
    a kernel is being made.
    """
    emitter = mi.load_dict({"type": "lumenray_luminaires"})
    emitter.palette = palette
    return emitter


def luminaires_class():
    """Make the emitter's class for the active variant."""

    class Luminaires(mi.Emitter):
        """Every luminaire of a `LuminairePalette`, told apart by the time of what it is asked with."""

        palette: LuminairePalette

        def __init__(self, props):
            mi.Emitter.__init__(self, props)
            self.m_flags = +mi.EmitterFlags.Surface

        def traverse(self, callback):
            """Nothing here is a parameter of Mitsuba's."""

        def eval(self, si, active=True):
            row, active = mi.UInt32(si.time), mi.Bool(active)
            lit = active & self.palette.is_outside(row, si, active)
            value = self.palette.radiance(row, si.to_world(si.wi), si.wavelengths, lit)
            return mi.Spectrum(value & lit)

        def sample_direction(self, it, sample, active=True):
            ds, value = self.palette.receive(mi.UInt32(it.time), it, sample, mi.Bool(active))
            ds.emitter = mi.EmitterPtr(self)
            return ds, value

        def pdf_direction(self, it, ds, active=True):
            return self.palette.density_at(mi.UInt32(it.time), it.p, ds.d, mi.Bool(active))

        def eval_direction(self, it, ds, active=True):
            value = self.palette.radiance(mi.UInt32(it.time), -ds.d, it.wavelengths, active)
            return mi.Spectrum(value & active)

        def bbox(self):
            return mi.BoundingBox3f()

        def to_string(self):
            return "Luminaires[]"

    return Luminaires
