"""Answers of a year in Blender: pictures as images, figures as a text."""

import bpy
import numpy as np

from ...engine.daylight.pictures import draw_all
from ...engine.daylight.words import describe
from ..bake.look import hide
from ..bake.results import unchanged
from ..bake.year_images import FACTS, remove_maps
from ..foundation.report import ConversionReport
from .job import YearJob
from .maps import draw_maps, store_maps

TEXT = "Lumenray Daylight Year"
"""Name of the text."""

IMAGES = {
    "hours.png": "Daylight Hours",
    "autonomy.png": "Daylight Autonomy",
    "factor.png": "Daylight Factor",
    "sunlight.png": "Daylight Sunlight",
}
"""Names of the images, by those of the pictures."""

LABEL = 22
"""Room for labels. [character]"""


def store(job: YearJob, notes, report: ConversionReport | None = None) -> list:
    """Keep the answer of a job as images and a text, in the place of an earlier one; return the pictures' images.

    ``report`` gets rows of objects that cannot hold their maps.
    """
    answer = job.answer
    place = answer.light.year.weather.place
    pictures = draw_all(
        answer.light, answer.figures, job.places.sensors[:, :3], job.question.zone or place.zone
    )
    lines = []
    for label, texts in describe(answer.light, answer.figures, job.question):
        lines += [f"{'' if i else label:<{LABEL}}{text}" for i, text in enumerate(texts)]
    provenance = answer.light.opened.coefficients.provenance
    lines += [
        f"{'sensors':<{LABEL}}{answer.light.sensors}, {provenance.samples} paths each, seed {provenance.seed}",
        f"{'scene':<{LABEL}}{provenance.scene_hash}",
        *_lines_of_maps(answer.maps),
        "",
        *(f"note: {note}" for note in (*notes, *answer.notes)),
    ]
    text = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
    text.from_string("\n".join(lines) + "\n")
    images = [_to_image(IMAGES[name], picture) for name, picture in pictures.items()]
    scene = bpy.context.scene
    with unchanged(scene):
        if scene.lumenray.look.figure:
            hide()
        remove_maps()
        if answer.maps is not None:
            store_maps(answer.maps, job.names, ConversionReport() if report is None else report)
    if answer.maps is None:
        return images
    for name, picture in draw_maps(answer.maps).items():
        image = _to_image(name, picture)
        image[FACTS] = {"figure": "picture"}
        images.append(image)
    return images


def read_figures(text) -> list[tuple[str, str]]:
    """Return labels and values of a text's figures, up to its notes."""
    made: list[tuple[str, str]] = []
    for line in text.lines:
        if not line.body:
            break
        made.append((line.body[:LABEL].strip(), line.body[LABEL:].strip()))
    return made


def find_images() -> list:
    """Return the images that there are."""
    found = map(bpy.data.images.get, IMAGES.values())
    return [image for image in found if image is not None] + [
        image for image in bpy.data.images if FACTS in image
    ]


def has_maps() -> bool:
    """Whether the file holds maps of a year; cheap enough for every redraw."""
    return any(FACTS in image for image in bpy.data.images)


def _lines_of_maps(maps) -> list[str]:
    """Say of every object with a map how much daylight its surface has."""
    lines = []
    for each in () if maps is None else maps.objects:
        text = "no lumel can be seen"
        if each.figures is not None:
            area = each.figures.area
            share, light = (float(area[name].value) for name in ("daylight_autonomy", "mean_lx"))
            text = f"autonomy {100.0 * share:.3g} %, mean {light:.4g} lx, {each.lumels} lumels"
        lines.append(f"{each.surface.name[: LABEL - 1]:<{LABEL}}{text}")
    return lines


def _to_image(name: str, picture):
    """Put a picture of Pillow into an image of Blender, which the file keeps."""
    width, height = picture.size
    image = bpy.data.images.get(name)
    if image is None or (image.source != "GENERATED" and not image.packed_file):
        image = bpy.data.images.new(name, width, height)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    values = np.ones((height, width, 4), dtype=np.float32)
    values[..., :3] = np.asarray(picture.convert("RGB"), dtype=np.float32)[::-1] / 255.0
    image.pixels.foreach_set(values.reshape(-1))
    image.update()
    image.pack()
    return image
