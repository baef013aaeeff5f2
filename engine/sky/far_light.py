"""What emitters of luminance by direction, infinitely far away, have in common."""

import drjit as dr
import mitsuba as mi


def far_light_class():
    """Return their base for the active Mitsuba variant."""

    class FarLight(mi.Emitter):
        """Luminance by direction. All that an edit can change is data, so it meets compiled kernels."""

        def __init__(self, props):
            mi.Emitter.__init__(self, props)
            self.radiance = props["radiance"]
            self.m_flags = +mi.EmitterFlags.Infinite

        def traverse(self, callback):
            callback.put("radiance", self.radiance, mi.ParamFlags.Differentiable)

        def eval_direction(self, it, ds, active=True):
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi, si.wavelengths = -ds.d, it.wavelengths
            return self.eval(si, active)

        def bbox(self):
            return mi.BoundingBox3f()

        def set_scene(self, scene):
            """Nothing of it depends on the scene; the surroundings keep the bounds."""

        def to_string(self):
            return f"{type(self).__name__}[]"

    return FarLight
