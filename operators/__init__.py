"""What a user can do: thin operators that gather input, call the add-on or the engine, and report."""

from . import (
    add_luminaire,
    bake_illuminance,
    check_engine,
    copy_report,
    luminaire_files,
    rayset_files,
    restart_engine,
    scattering_files,
    show_baked,
)

CLASSES = (
    *add_luminaire.CLASSES,
    *bake_illuminance.CLASSES,
    *check_engine.CLASSES,
    *copy_report.CLASSES,
    *luminaire_files.CLASSES,
    *rayset_files.CLASSES,
    *restart_engine.CLASSES,
    *scattering_files.CLASSES,
    *show_baked.CLASSES,
)
