"""Whether a scene is computed by the user's cluster, and where that is."""

import importlib.util

import bpy

from ...engine.errors import LumenrayError
from ...imports import loaded_when_used
from .preferences import cluster

with loaded_when_used():
    from ...engine.cluster import security

Place = tuple[str, str, str, str]
"""Address, and the names of three files, as of `engine.cluster.shared_session.ClusterPlace`."""


def has_dask() -> bool:
    """Whether what clusters need is installed."""
    return importlib.util.find_spec("distributed") is not None


def place_of(scene) -> Place | None:
    """Return the cluster that computes a scene, None where this computer does.

    Raises
    ------
    LumenrayError    It is wanted and not named, its address is none, or Blender is to stay off networks.
    """
    return named_place() if scene.lumenray.use_cluster else None


def named_place() -> Place:
    """Return the user's cluster. Raises as `place_of`."""
    place = cluster()
    if not place[0]:
        raise LumenrayError(
            "no cluster is named: give its address in Render > Cluster, or have this computer compute there"
        )
    if not security.read_address(place[0]).is_own_machine and not bpy.app.online_access:
        raise LumenrayError(
            f"{place[0]} is another computer, and Blender is set to stay offline: allow online access in Preferences > "
            "System > Network"
        )
    return place
