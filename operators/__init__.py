"""What a user can do: thin operators that gather input, call the add-on or the engine, and report."""

from . import (
    add_luminaire,
    add_preset,
    bake_illuminance,
    check_engine,
    copy_report,
    list_lights,
    luminaire_files,
    mix_lights,
    new_lit_room,
    open_office,
    rayset_files,
    restart_engine,
    scattering_files,
    show_baked,
    sun_lamp,
    try_devices,
)

CLASSES = (
    *add_luminaire.CLASSES,
    *add_preset.CLASSES,
    *bake_illuminance.CLASSES,
    *check_engine.CLASSES,
    *copy_report.CLASSES,
    *list_lights.CLASSES,
    *luminaire_files.CLASSES,
    *mix_lights.CLASSES,
    *new_lit_room.CLASSES,
    *open_office.CLASSES,
    *rayset_files.CLASSES,
    *restart_engine.CLASSES,
    *scattering_files.CLASSES,
    *show_baked.CLASSES,
    *sun_lamp.CLASSES,
    *try_devices.CLASSES,
)
