"""Render tab: the cluster that computes in place of this computer."""

import bpy

from ..blender_addon.foundation import cluster_place, preferences
from .parts import draw_text
from .render import RenderPanel

NO_DASK = "Not installed: install the zip lumenray-cluster for this platform and Blender version as you did Lumenray's"

QUIET = 15.0
"""Time without a sign of life after which a worker is shown as silent: nobody counts on it any more then, see
`engine.cluster.dispatch.SILENCE`. [s]"""

MOST_SHOWN = 12
"""Workers that have a line of their own."""


class LUMENRAY_PT_cluster(RenderPanel, bpy.types.Panel):
    """Where the cluster is, and who computes there."""

    bl_label = "Cluster"
    bl_order = 2
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.lumenray, "use_cluster", text="")

    def draw_settings(self, layout, context, settings):
        """Draw the address, which is of the preferences, and the workers as they were last seen."""
        own = preferences.own()
        if own is None:
            return
        if not cluster_place.has_dask():
            draw_text(layout, context, NO_DASK, "INFO")
        layout.prop(own, "cluster_address", text="Address")
        if own.cluster_address.strip().startswith("tls:"):
            for name in ("cluster_authority", "cluster_certificate", "cluster_key"):
                layout.prop(own, name)
        layout.operator("lumenray.find_workers", icon="FILE_REFRESH")
        _draw_workers(layout, context, own.cluster_address.strip())


def _draw_workers(layout, context, address: str) -> None:
    found = context.window_manager.lumenray.cluster
    if not found.is_known or found.address != address:
        return
    count = len(found.workers)
    if not count:
        draw_text(
            layout,
            context,
            "No worker is there; start some with 'lumenray cluster worker'",
            "ERROR",
        )
        return
    column = layout.column(align=True)
    column.label(text="1 worker" if count == 1 else f"{count} workers", icon="NETWORK_DRIVE")
    for worker in found.workers[:MOST_SHOWN]:
        is_silent = worker.silence > QUIET
        words = f"{worker.name}, silent for {worker.silence:.0f} s" if is_silent else worker.name
        column.label(text=words, icon="ERROR" if is_silent else "CHECKMARK")
    if count > MOST_SHOWN:
        column.label(text=f"and {count - MOST_SHOWN} more", icon="NONE")


CLASSES = (LUMENRAY_PT_cluster,)
"""For registration."""
