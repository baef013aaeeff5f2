"""Cycles as a rival: it bakes the same page with the same texture coordinates."""

from pathlib import Path

import numpy as np

from ...engine.baking.order import BakeResult
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import Scene, SceneDelta
from ...validation.bench import CannotStateError
from ...validation.peers.contents import sort_items
from ...validation.peers.cycles_scene import describe
from ..common.cycles_process import CyclesProcess
from .scenes import AtlasScene

TASK = Path(__file__).with_name("cycles_page.py")

PATIENCE = 900.0
"""Longest that one page may take. [s]"""

SEED = 5


class CyclesBake:
    """Cycles with all its limits at their most accurate. `close` ends its process.

    Parameters
    ----------
    scene : AtlasScene    Plain, see `variants.make_plain`.
    result : BakeResult    Ours, for the texture coordinates; one page.

    Raises
    ------
    CannotStateError    The package `bpy` is missing, or Cycles has nothing for a part of the scene.
    """

    def __init__(self, scene: AtlasScene, result: BakeResult):
        if len(result.pages) != 1:
            raise CannotStateError("more than one page is not translated")
        self._request = _describe(scene, result)
        self._process = CyclesProcess(TASK, PATIENCE)

    def run(self, samples: int) -> tuple[np.ndarray, float]:
        """Page (h, w) of illuminances [lx], and the seconds that the bake took by Blender's own clock."""
        return self._process.ask(self._request | {"samples": samples, "seed": SEED})

    def close(self) -> None:
        """End the process."""
        self._process.close()


def _describe(scene: AtlasScene, result: BakeResult) -> dict:
    """Request without samples and seed."""
    held = Scene()
    held.apply(SceneDelta(changed=scene.items))
    baked = {made.id: made for made in result.maps}
    meshes = [held.mesh(key) for key in held.meshes]
    others = [item for item in meshes if item.id not in baked]
    rest = [*held.materials.values(), *others, *held.lights.values()]
    if held.world is not None:
        rest.append(held.world)
    # In metres about the world's origin: these scenes are small.
    request = describe(sort_items(rest), np.zeros(3), 1.0)
    request["target"] = _target(held, [item for item in meshes if item.id in baked], baked)
    page = result.pages[0]
    return request | {"size": (page.height, page.width)}


def _target(held: Scene, meshes: list[Mesh], baked: dict) -> dict:
    """What is baked, as one object."""
    corners, uv, slots, names = [], [], [], {}
    for mesh in meshes:
        layout = baked[mesh.id].layout
        corners.append(mesh.vertices[mesh.triangles])
        # What has no place lies at a corner of the page, with no extent.
        uv.append(np.where((layout.page >= 0)[:, None, None], layout.uv, 0.0))
        rows = np.array([names.setdefault(key, len(names)) for key in mesh.materials])
        slots.append(rows[np.minimum(mesh.material_index, len(rows) - 1)])
    descriptions = []
    for key in names:
        part = Mesh(
            "part",
            "part",
            np.eye(3),
            np.array([[0, 1, 2]], dtype=np.int32),
            (key,),
            np.zeros(1, dtype=np.int32),
        )
        made = describe(sort_items([held.materials[key], part]), np.zeros(3), 1.0)["meshes"]
        if not made or made[0]["material"]["kind"] != "diffuse":
            raise CannotStateError(f"Cycles bakes what is diffuse, and '{key}' is not")
        descriptions.append(made[0]["material"])
    return {
        "corners": np.concatenate(corners),
        "uv": np.concatenate(uv),
        "slot": np.concatenate(slots),
        "materials": descriptions,
    }
