"""Rays that smooth glass, mirrors and panes send on by single directions, as both ways of following light over bends do."""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi

from ..compiled.polarisation import polarise
from ..paths.wavelengths import disperse
from ..rays import spawn_ray

ROULETTE_START = 4
"""Number of bends before roulette begins."""

SURVIVAL = 0.97
"""Largest probability of going on, so that light that glass holds back for ever ends."""


@dataclass
class BentRays:
    """State of rays on the device.

    Parameters
    ----------
    ray : Ray3f    Along which light goes on.
    stream : PCG32
    active : Bool
    dispersed : Bool    Whether one wavelength is left.
    throughput : Spectrum    Of the way so far.
    bends : UInt32    So far; panes, cut-outs and known mirrors do not bend.
    steps : UInt32    Surfaces so far.
    polar : Vector3f    Polarisation.
    """

    ray: object
    stream: object
    active: object
    dispersed: object = field(default_factory=lambda: mi.Bool(False))
    throughput: object = field(default_factory=lambda: mi.Spectrum(1.0))
    bends: object = field(default_factory=lambda: mi.UInt32(0))
    steps: object = field(default_factory=lambda: mi.UInt32(0))
    polar: object = field(default_factory=lambda: mi.Vector3f(0.0))

    def go_on(self, scene, si, bs, weight):
        """Send rays on from a surface; those that are spread out end.

        Parameters
        ----------
        scene : CompiledScene
        si : SurfaceInteraction3f
        bs, weight : BSDFSample3f, Spectrum    Where it sends them, and how much of them.

        Returns
        -------
        Bool    Which do not go straight on.
        """
        # Straight passes are among Mitsuba's Delta.
        self.active &= mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        straight = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        turned = self.active & ~straight
        throughput = dr.select(self.active, self.throughput * weight, self.throughput)
        throughput, self.dispersed = disperse(scene, bs, throughput, self.dispersed, turned)
        is_bend = turned
        if scene.mirrors is not None:
            is_bend = turned & (scene.mirror_at(si, turned) == 0)
        self.bends = dr.select(is_bend, self.bends + 1, self.bends)
        # Straight means straight: turned into the surface's frame and back, rays would drift.
        direction = dr.select(straight, self.ray.d, si.to_world(bs.wo))
        factor, self.polar = polarise(
            scene, si, self.ray.d, direction, self.polar, turned, self.active
        )
        self.throughput = throughput * factor
        self.ray = dr.select(self.active, spawn_ray(scene, si, direction), self.ray)
        self.steps += 1
        return turned

    def play_roulette(self, turned, most: int) -> None:
        """End rays that bring little. ``most``: steps, so that numerical trouble lets none go on for ever."""
        tried = turned & (self.bends >= ROULETTE_START)
        # Radiance is larger in a dense body and smaller again outside.
        survival = dr.minimum(dr.max(self.throughput), SURVIVAL)
        self.active &= ~tried | (self.stream.next_float32() < survival)
        throughput = self.throughput / dr.maximum(survival, 1e-20)
        self.throughput = dr.select(tried & self.active, throughput, self.throughput)
        self.active &= dr.any(self.throughput != 0.0) & (self.steps < most)
