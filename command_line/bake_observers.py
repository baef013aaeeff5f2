"""Glare of the observers that stand in a file, beside its lux maps."""

from dataclasses import replace

from ..engine.judgement.requirement import Requirement
from .cluster_options import open_engine
from .output import say
from .progress import Bar

FILE = "observers.json"
"""Name of the file with their ratings."""


def observers_of(scene) -> list:
    """Return the empties of a scene that stand for observers of glare."""
    from ..blender_addon.sensors.places import GLARE
    from ..blender_addon.sensors.settings import find_sensors

    return [empty for empty in find_sensors(scene) if empty.lumenray.sensor.quantity == GLARE]


def judge_observers(options, depsgraph, requirement: Requirement) -> None:
    """Rate the observers of a file, say whether they meet a requirement, and write it beside the lux maps.

    Does nothing where there are none, or the requirement asks nothing of glare.
    """
    from ..blender_addon.sensors import asked, files, judging
    from ..engine.light_mix import NEUTRAL

    empties = observers_of(depsgraph.scene)
    if not empties or "ugr" not in requirement.light:
        return
    job, report = asked.prepare(depsgraph, empties, accept_missing=options.accept_missing)
    settings = depsgraph.scene.lumenray
    job.seed = settings.seed if options.seed is None else options.seed
    job.transport = options.transport or settings.transport.lower()
    # Ratings are of all light together.
    job.groups = ()
    with open_engine(options) as session, Bar("observe") as bar:
        job.run(session, bar)
    named = [(placed.name, job.answer[placed.uid]) for placed in job.places]
    glare = replace(requirement, areas={}, light={"ugr": requirement.light["ugr"]})
    judged = judging.judge_sensors([(*row, None) for row in named], glare)
    for line in judging.tell(judged):
        say(line)
    files.write_document(
        options.output / FILE,
        options.file.name,
        named,
        NEUTRAL,
        report.to_dicts(),
        job.notes,
        requirement=judging.describe(judged),
    )
