"""Panels. They show and name things; whatever has to be found out is found out in `blender_addon`."""

from ..blender_addon.bake import error_graph as error_graphs
from ..blender_addon.cloths.preview import pictures as cloth_pictures
from ..blender_addon.luminaires.preview import pictures as luminaire_pictures
from ..blender_addon.paints.preview import pictures as paint_pictures
from ..blender_addon.scattering.preview import pictures as scattering_pictures
from . import (
    add_menu,
    bake,
    cloth,
    cluster,
    compatibility,
    daylight_year,
    ground_overlay,
    image_header,
    ink,
    light,
    light_list,
    light_mix,
    lighting_scenes,
    luminaire,
    luminaire_overlay,
    material,
    modelling,
    paint,
    presets,
    rayset,
    rayset_overlay,
    render,
    report,
    scattering,
    sensor_overlay,
    sensors,
    sidebar,
    start,
    sun_arc,
    tube_overlay,
    world,
)

CLASSES = (
    *light.CLASSES,
    *luminaire.CLASSES,
    *rayset.CLASSES,
    *material.CLASSES,
    *scattering.CLASSES,
    *paint.CLASSES,
    *ink.CLASSES,
    *cloth.CLASSES,
    *world.CLASSES,
    *daylight_year.CLASSES,
    *presets.CLASSES,
    *render.CLASSES,
    *cluster.CLASSES,
    *modelling.CLASSES,
    *start.CLASSES,
    *sidebar.CLASSES,
    *light_list.CLASSES,
    *light_mix.CLASSES,
    *lighting_scenes.CLASSES,
    *sensors.CLASSES,
    *report.CLASSES,
    *bake.CLASSES,
    *add_menu.CLASSES,
)


def attach():
    """Let Blender's own panels appear for our engine, and draw what has no shape of Blender's own in 3D views."""
    compatibility.attach()
    luminaire_overlay.attach()
    rayset_overlay.attach()
    tube_overlay.attach()
    sun_arc.attach()
    sensor_overlay.attach()
    ground_overlay.attach()
    add_menu.attach()
    image_header.attach()


def detach():
    """Undo `attach`, and let go of all pictures."""
    image_header.detach()
    add_menu.detach()
    ground_overlay.detach()
    sensor_overlay.detach()
    sun_arc.detach()
    tube_overlay.detach()
    rayset_overlay.detach()
    luminaire_overlay.detach()
    luminaire_pictures.close()
    scattering_pictures.close()
    paint_pictures.close()
    cloth_pictures.close()
    error_graphs.close()
    compatibility.detach()
