"""Random walks of light from where it begins until it is absorbed or leaves, and what it meets on the way.

As in `deposits`, the flux of a path is no denser in a denser body, so the square of the relative index that surface models
apply is taken back, and a facet sends on all flux that it receives whatever its shading normals say: light that they would
send to the wrong side is mirrored at the facet. So energy is kept, and every loss is absorption.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ..compiled.polarisation import polarise
from ..light_tracing.deposits import bend
from ..paths.lost_samples import LostSamples
from ..paths.visibility import meet
from ..paths.wavelengths import disperse
from ..rays import spawn_ray
from .sums import Sums

FADED = 0.1
"""Share of its first power below which a path plays roulette. What came before is counted as it fades, so that a path in a
white room says nine tenths of what it has to say without chance."""

LONG, SURVIVAL = 512, 0.98
"""Surfaces on a path beyond which it goes on with such a probability at most, so that light that glass or perfect mirrors
hold for ever ends."""

MAXIMUM_STEPS = 5_000
"""Surfaces on a path after which it is cut off; its light is told apart."""

NEAR = 0.01
"""Way to the first surface, relative to the scene's radius, below which light begins very near something."""

NOBODY = 0xFFFFFFFF
"""Entry of tables for what nobody asks about."""

BENT, MIRRORED, PASSED, CLOSE, LEFT, CUT = 1, 2, 4, 8, 16, 32
"""Traces that ways leave: through smooth bodies, over mirrors, straight through panes and cut-outs, first met very near the
light; and how they end."""


@dataclass
class Tally:
    """What is counted, on the device; all arrays hold ``batches`` entries for each of their rows.

    Parameters
    ----------
    rows : UInt32    Row of the front of every shape, then of its back; `NOBODY`: not counted.
    incident, absorbed : Sums    By row. [lm]
    left, cut, lost : Sums    One row each: light that leaves the scene, is cut off, is absorbed anywhere. [lm]
    batches : int
    faults : LostSamples    Of ways that ended at what is no number; one row.
    """

    rows: object
    incident: Sums
    absorbed: Sums
    left: Sums
    cut: Sums
    lost: Sums
    batches: int
    faults: LostSamples


def make_tally(rows, count: int, batches: int, flux: float) -> Tally:
    """Counters at 0. ``count``: rows; ``flux``: about that of all lights [lm]."""
    # One row at least, where the scene has no objects.
    many = max(count, 1) * batches
    sizes = (many, many, batches, batches, batches)
    return Tally(rows, *(Sums(size, flux) for size in sizes), batches, LostSamples(1))


def walk(scene, rays, tally: Tally, batch, stream, limit, steps, sheets=None, watcher=None):
    """Follow rays.

    Parameters
    ----------
    scene : CompiledScene
    rays : Rays
    tally : Tally    Gets what is met.
    batch : UInt32    Which of the tally's batches every ray belongs to.
    stream : PCG32
    limit : UInt32    Most scatterings of light that counts.
    steps : UInt32    Most surfaces on a path.
    sheets : Sheets or None    Small surfaces in the air that count what crosses them.
    watcher : Watcher or None    Is told of everything that one of them, or one row, receives.

    Returns
    -------
    (Float, UInt32)    Flux that every ray brought to rows and sheets, all times counted [lm], and surfaces that it met.
    """
    state = {
        "origin": mi.Point3f(rays.ray.o),
        "direction": mi.Vector3f(rays.ray.d),
        "stream": mi.PCG32(stream),
        "power": mi.Spectrum(rays.power),
        "scatterings": mi.UInt32(0),
        "steps": mi.UInt32(0),
        "trace": mi.UInt32(0),
        "bender": mi.UInt32(NOBODY),
        "use": mi.Float(0.0),
        "lost": mi.Float(0.0),
        "polar": mi.Vector3f(0.0),
        "dispersed": mi.Bool(False),
        "active": mi.Bool(dr.any(rays.power > 0.0)),
    }
    first = dr.maximum(rays.lumens(rays.power), 1e-30)
    close = NEAR * scene.extent
    many = mi.UInt32(tally.batches)

    def add(target, row, amount, active, chance):
        target.add(amount, row * many + batch, active, chance)

    def body(
        origin, direction, stream, power, scatterings, done, trace, bender, use, lost, polar, dispersed, active
    ):  # fmt: skip
        ray = mi.Ray3f(origin, direction, mi.Float(0.0), rays.ray.wavelengths)
        hit, si = meet(scene, ray, active)
        amount = rays.lumens(power)
        counts = active & (scatterings <= limit)
        chance = stream.next_float32()
        if sheets is not None:
            found = sheets.count(
                ray, dr.select(si.is_valid(), hit.t, dr.inf), amount, batch, counts, chance,
                watcher, (scatterings, trace, bender),
            )  # fmt: skip
            use = use + found
        leaves = active & ~si.is_valid()
        trace = dr.select(leaves, trace | LEFT, trace)
        active &= si.is_valid()
        counts &= active

        # ---- what arrives ----
        trace |= dr.select(active & (done == 0) & (hit.t < close), mi.UInt32(CLOSE), 0)
        number = dr.reinterpret_array(mi.UInt32, si.shape)
        facing = dr.dot(direction, si.n)
        side = dr.select(facing > 0.0, mi.UInt32(1), mi.UInt32(0))
        row = dr.gather(mi.UInt32, tally.rows, number * 2 + side, active)
        counts &= row != NOBODY
        add(tally.incident, row, amount, counts, chance)
        use = dr.select(counts, use + amount, use)
        if watcher is not None:
            watcher.see_row(row, amount, scatterings, trace, bender, counts)

        # ---- going on ----
        bsdf = scene.bsdf(si, active)
        is_askew = mi.Frame3f.cos_theta(si.wi) * facing >= 0.0
        si.sh_frame = dr.select(is_askew, mi.Frame3f(mi.Vector3f(si.n)), si.sh_frame)
        si.wi = si.to_local(-direction)
        bs, weight = bend(si, bsdf, stream, active)
        straight = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        reflects = mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(bs.wo) > 0.0
        onwards = dr.select(straight, direction, si.to_world(bs.wo))
        rise = dr.dot(onwards, si.n)
        is_wrong = ~straight & (reflects == (rise * facing > 0.0))
        onwards = dr.select(is_wrong, onwards - si.n * (2.0 * rise), onwards)
        factor, polar = polarise(scene, si, direction, onwards, polar, active & ~straight, active)
        weight = weight * factor
        # What is lost counts as absorbed.
        weight = mi.Spectrum(*tally.faults.keep(weight, mi.UInt32(0), active))
        after = mi.Spectrum(power * weight)
        after, dispersed = disperse(scene, bs, after, dispersed, active & ~straight)
        loss = amount - rays.lumens(after)
        counts = active & (row != NOBODY)
        add(tally.absorbed, row, loss, counts, chance)
        lost = dr.select(active, lost + loss, lost)

        turned = active & ~straight
        delta = turned & mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        passes = active & straight & (row != NOBODY)
        mark = dr.select(delta, dr.select(reflects, mi.UInt32(MIRRORED), mi.UInt32(BENT)), 0)
        mark = dr.select(passes, mi.UInt32(PASSED), mark)
        bender = dr.select((bender == NOBODY) & (mark > 0), number, bender)
        trace = trace | mark
        scatterings = dr.select(turned, scatterings + 1, scatterings)
        done += 1
        beginning = spawn_ray(scene, si, onwards)
        origin = dr.select(active, beginning.o, origin)
        direction = dr.select(active, onwards, direction)
        power = mi.Spectrum(dr.select(active, after, power))

        # ---- ends ----
        active &= dr.any(power != 0.0)
        amount = rays.lumens(power)
        is_cut = active & (done >= steps)
        trace = dr.select(is_cut, trace | CUT, trace)
        active &= ~is_cut
        left = amount / first
        is_long = done > LONG
        tried = turned & active & ((left < FADED) | is_long)
        survival = dr.minimum(left * (1.0 / FADED), dr.select(is_long, SURVIVAL, 1.0))
        active &= ~tried | (stream.next_float32() < survival)
        power = mi.Spectrum(dr.select(tried & active, power / survival, power))
        return (
            origin,
            direction,
            stream,
            power,
            scatterings,
            done,
            trace,
            bender,
            use,
            lost,
            polar,
            dispersed,
            active,
        )

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda *values: values[-1],
        body=body,
        labels=tuple(state),
    )
    end = dict(zip(state, result, strict=True))
    rest = rays.lumens(end["power"])
    dr.eval(
        end["use"], end["steps"], end["lost"], end["trace"], rest,
        tally.incident.counts, tally.absorbed.counts,
    )  # fmt: skip
    chance = end["stream"].next_float32()
    add(tally.left, 0, rest, (end["trace"] & LEFT) > 0, chance)
    add(tally.cut, 0, rest, (end["trace"] & CUT) > 0, chance)
    add(tally.lost, 0, end["lost"], mi.Bool(True), chance)
    dr.eval(tally.left.counts, tally.cut.counts, tally.lost.counts)
    return end["use"], end["steps"]
