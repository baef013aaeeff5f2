"""What the user can start."""

from . import check_engine, copy_report

CLASSES = (*check_engine.CLASSES, *copy_report.CLASSES)
