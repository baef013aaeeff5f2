"""What a user can do: thin operators that gather input, call the add-on or the engine, and report."""

from . import bake_illuminance, check_engine, copy_report, restart_engine

CLASSES = (
    *bake_illuminance.CLASSES,
    *check_engine.CLASSES,
    *copy_report.CLASSES,
    *restart_engine.CLASSES,
)
