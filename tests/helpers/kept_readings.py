"""Sensors in a made-up room whose light groups are known exactly: the engine is a fake that adds noise of a stated size."""

from types import SimpleNamespace

import bpy
import numpy as np
from blender_bakes import add_lamp

from lumenray.blender_addon.rendering import light_mix
from lumenray.blender_addon.sensors import asked, results
from lumenray.engine.scene.provenance import Provenance

LUX = {"Ceiling": 400.0, "Desk": 200.0}
"""What the lamps of each group give to every sensor, reflected light included; direct light is half of it. [lx]"""

NOISE = 0.01
"""Relative standard error of each group."""


class FakeMeters:
    """Answers with the lux of the groups that shine."""

    def __init__(self, owner, noise=NOISE, simplified=0.0):
        self.owner, self.noise, self.simplified, self.shining = owner, noise, simplified, {}

    def apply(self, delta):
        self.shining = {k: v for k, v in self.shining.items() if k not in delta.removed}
        self.shining |= {item.id: item for item in delta.changed if item.id in self.owner}

    def measure(self, positions, normals, rule, seed, *_, reflections=None, **__):
        share = 0.5 if reflections == 0 else 1.0
        exact = share * sum(LUX[self.owner[key]] for key in self.shining)
        noise = np.random.default_rng(seed + (reflections == 0)).normal(size=len(positions))
        error = np.full(len(positions), max(np.hypot(self.noise, self.simplified) * exact, 1e-9))
        origin = Provenance(
            "0", "mono", "", seed, 16, 1.0, notes=("a note",), simplified=self.simplified
        )
        return SimpleNamespace(
            illuminance=exact + error * noise,
            standard_error=error,
            provenance=origin,
            method="made up",
            has_common_errors=True,
        )


def new_room(name="Desk A", requirement="office.writing", length=2.0, width=1.0):
    """Add two lamps in groups and a grid of sensors that something is required of; keep groups apart and list them."""
    for group in LUX:
        add_lamp(f"{group} Lamp", group)
    empty = bpy.data.objects.new(name, None)
    own = empty.lumenray.sensor
    own.is_sensor, own.layout, own.length, own.width = True, "GRID", length, width
    own.requirement = requirement
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.scene.lumenray.light_mix.groups = "GROUPS"
    light_mix.list_rows(bpy.context.scene, list(LUX))
    return empty


def measure(noise=NOISE, simplified=0.0):
    """Measure all sensors of the scene by the fake, and keep what they tell."""
    bpy.context.view_layer.update()
    job, _ = asked.prepare(bpy.context.evaluated_depsgraph_get())
    owner = {key: group.name for group in job.groups for key in group.members}
    job.run(FakeMeters(owner, noise, simplified))
    results.store(job)
    return job


def set_sliders(**factors):
    """Set the sliders of the light mix by the names of groups; 0 is off."""
    for row in bpy.context.scene.lumenray.light_mix.rows:
        row.factor = factors.get(row.name, 1.0)
        row.is_on = row.factor > 0.0
