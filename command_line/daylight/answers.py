"""What the command writes and says of a year."""

from ..output import percent, sheet
from .places import Places

MATRIX = "illuminance.csv"
"""Table of every sensor at every hour."""


def write(options, light, figures, places: Places, question, remarks) -> None:
    """Tables and pictures."""
    from ...engine.analysis import canvas
    from ...engine.daylight import pictures, tables
    from ...engine.formats.report import write_json

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
            "remarks": list(remarks),
        },
    )
    for name, picture in pictures.draw_all(light, figures, places.sensors[:, :3], zone).items():
        canvas.save_picture(picture, folder / name)


def make_sheet(options, light, figures, question) -> str:
    """Figures of the area for the terminal."""
    place = light.year.weather.place
    area = figures.area

    def told(name: str, as_share: bool = True) -> str:
        value, low, high = area[name].value, *area[name].interval()
        if as_share:
            return f"{percent(float(value))}, between {percent(max(float(low), 0.0))} and {percent(float(high))}"
        return f"{float(value):.4g}, between {float(low):.4g} and {float(high):.4g}"

    start, end = options.hours
    rows = [
        ("place", f"{place.name} ({place.latitude:.2f}, {place.longitude:.2f})"),
        ("hours", f"{start:g} to {end:g} h of {question.zone or place.zone}"),
        (
            "daylight factor",
            [f"median {told('daylight_factor_median')}", f"mean {told('daylight_factor_mean')}"],
        ),
        ("mean illuminance", f"{told('mean_lx', False)} lx"),
        (f"autonomy {question.target:g} lx", told("daylight_autonomy")),
        ("sDA 300/50 %", told("sda")),
        ("ASE 1000, 250 h", told("ase")),
    ]
    for method, words in (
        ("factors", "EN 17037 by factors"),
        ("illuminances", "EN 17037 by hours"),
    ):
        found = figures.provision.get(method)
        if found is not None:
            open_words = (
                ""
                if found.lowest == found.highest
                else f", between {found.lowest} and {found.highest} by the noise"
            )
            rows.append((words, f"{found.level}{open_words}"))
    if figures.sunlight_level:
        hours = float(figures.sensors["sunlight_of_day_h"].value.max())
        rows.append(("sunlight", f"{figures.sunlight_level}, {hours:.1f} h at the best sensor"))
    rows.append(("probability", "intervals hold the true values with 95 %"))
    return sheet(str(options.file), rows)
