"""What the command writes and says of a year."""

from ...blender_addon.daylight_year.job import Places
from .map_files import summarise_maps, write_maps

MAPS = "maps"
"""Folder of maps."""

MATRIX = "illuminance.csv"
"""Table of every sensor at every hour."""


def write(options, answer, places: Places, question, remarks) -> None:
    """Tables, pictures and maps."""
    from ...engine.analysis import canvas
    from ...engine.daylight import pictures, tables
    from ...engine.formats.report import write_json

    light, figures, maps = answer.light, answer.figures, answer.maps
    folder, zone = options.output, question.zone or light.year.weather.place.zone
    tables.write_sensors(folder / "sensors.csv", places.sensors, places.areas, figures, remarks)
    tables.write_hours(folder / "hours.csv", light, figures, zone, remarks)
    if options.hourly:
        tables.write_matrix(folder / MATRIX, light, zone, remarks)
    provenance = light.opened.coefficients.provenance
    place = light.year.weather.place
    write_json(
        folder / "summary.json",
        {
            "engine": {"version": provenance.engine_version, "variant": provenance.variant},
            "scene": {"file": str(options.file), "hash": provenance.scene_hash},
            "weather": {
                "file": str(options.weather),
                "place": place.name,
                "latitude": place.latitude,
                "longitude": place.longitude,
            },
            "seed": provenance.seed,
            "samples": provenance.samples,
            "sensors": light.sensors,
            "figures": tables.summarise(figures),
            "maps": [] if maps is None else summarise_maps(maps),
            "remarks": list(remarks),
        },
    )
    for name, picture in pictures.draw_all(light, figures, places.sensors[:, :3], zone).items():
        canvas.save_picture(picture, folder / name)
    if maps is not None:
        facts = {
            "sceneHash": provenance.scene_hash,
            "seed": str(provenance.seed),
            "samples": str(provenance.samples),
            "freedom": f"{light.freedom:g}",
            "weather": place.name,
        }
        write_maps(folder / MAPS, maps, facts)
