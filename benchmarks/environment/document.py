"""The document of the benchmark of pictures of the surroundings, made of its numbers."""

from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from .suns import HEIGHT, LOW_SUN, NEAR_NOON

KEPT, DIRECTION, MINUTES, SUN, EDGE = 0.1, 0.1, 3.0, 1.0, 0.01
"""Most that illuminances [%], directions [degree], times [min], suns [%] and shadows [-] may be off."""

TITLE = """# Pictures of the surroundings

*Made by `lumenray benchmark environment`; do not edit by hand.*

Bright sources of equirectangular pictures taken out as lights, clipped suns mended, and what is said of pictures.
{cpu}, {cores} cores; Mitsuba {mitsuba}, Lumenray {lumenray}. To repeat it:
`lumenray benchmark environment --maps FOLDER --json out/environment.json`; parts by themselves with
`--parts maps,shadow,repair,noise,shadows,files,collection`, and more of them into the same numbers with `--resume`.

"""

MAPS = """## Maps with known suns

Disks over an even sky of 1 and a ground of 0.2, {height} rows; *clip*: the largest value that is kept, as by a camera.
*kept*: difference of the horizontal illuminance of the clipped map and its lights from that of the map; *direction*: angle
between a source and where it was drawn.

"""

SHADOW = """## Shadows

Sensors 10 m below the edge of a plate, lit by a sun that was taken out of a map: share of its light against the closed form
for the sun's disk. *width*: between 1 % and 99 % of the light, over the disk's own shadow.

"""

REPAIR = """## Suns mended

Clear skies of the CIE with their suns for random moments of four places, 2026, drawn, turned and clipped; time, and sun by
one place of the sky, found again. Nearer to noon than {noon:.0f} minutes the sun's height says little of the time, and of
suns lower than {low:g}° the light changes by more than 5 % a degree, where the place of a clipped sun is known to half a
pixel: the demands on time and sun do not count these. How wide a time is within half a pixel of the height, and by how much
that changes the sun, is said with every result (*stated*): all times have to lie within.

"""

NOISE = """## Noise

64 sensors on the ground round a wall under a clear sky with its sun, the same number of samples: the sun in the map, and
as a light beside the clipped map. Means of three runs each.

"""

FILES = """## Files that are odd, damaged or large

*peak*: most memory of the process up to then.

"""

COLLECTION = """## A collection of pictures

By Radiance's 179 lm/W; pictures from the web mostly have no absolute scale.

"""


CATCHERS = """## Shadow catchers and photomontages

Pixels of a catcher that nothing shades; ratios of shadows against sensors; the sun's direction by dragging, and a montage
against the render of all that its photo shows. *mirror* and *caustic*: what a chrome sphere on the ground of a map shows,
its own shadow among it, and where it makes the ground brighter, against the render of all.

"""


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    parts = result["parts"]
    shadow, shadows = parts.get("shadow"), parts.get("shadows")
    rows, mended = parts.get("maps") or (), parts.get("repair") or ()
    counts = [row for row in rows if row["found"] == row["expected"]]
    return [
        _below("horizontal illuminance kept", result["illuminance_error_percent"], KEPT, " %", 5),
        _below("directions of sources", result["direction_error_deg"], DIRECTION, "°", 3),
        Bar(
            "maps whose sources are all found, and no others",
            "all",
            f"{len(counts)} of {len(rows)}" if rows else "-",
            len(counts) == len(rows) if rows else None,
        ),
        _below(
            "shadow of an edge, share of the sun's light",
            shadow and shadow["largest_difference"],
            EDGE,
            "",
            4,
        ),
        _below("time by the sun's height", result["repair_minutes"], MINUTES, " min", 2),
        Bar(
            "times within what is stated",
            "all",
            f"{sum(row['is_within'] for row in mended)} of {len(mended)}" if mended else "-",
            all(row["is_within"] for row in mended) if mended else None,
        ),
        _below("sun by a place of the sky", result["rebuilt_error_percent"], SUN, " %", 3),
        _below(
            "unshaded pixels of a catcher", shadows and shadows["unshadowed_change"], 1e-3, "", 6
        ),
        _below("shadows on a catcher", result["shadow_error_percent"], 1.0, " %", 3),
        _below("sun by dragging", shadows and shadows["direction_error_deg"], 1.0, "°", 3),
        _below("photomontage", shadows and shadows["composite_error_percent"], 5.0, " %", 2),
        _below("chrome sphere", shadows and shadows["mirror_error_percent"], 5.0, " %", 2),
        _below("caustic on a ground", shadows and shadows["caustic_error_percent"], 5.0, " %", 2),
    ]


def _below(demand: str, value: float | None, limit: float, unit: str, digits: int) -> Bar:
    if value is None:
        return Bar(demand, f"at most {limit:g}{unit}", "-", None)
    return Bar(demand, f"at most {limit:g}{unit}", f"{value:.{digits}f}{unit}", value <= limit)


def describe(result: dict) -> str:
    """Return the document."""
    parts = result["parts"]
    tellers = {
        "maps": _tell_maps,
        "shadow": _tell_shadow,
        "repair": _tell_repair,
        "noise": _tell_noise,
        "shadows": _tell_catchers,
        "files": _tell_files,
        "collection": _tell_collection,
    }
    text = TITLE.format(**result["machine"]) + tell_demands(check_bars(result)) + "\n"
    return text + "\n".join(tell(parts[name]) for name, tell in tellers.items() if name in parts)


def _tell_maps(rows) -> str:
    lines = [
        f"| {row['map']} | {'-' if row['clip'] is None else format(row['clip'], 'g')} | {row['found']} of "
        f"{row['expected']} | {row['error_percent']:.1e} % | {row['direction_deg']:.3f}° |"
        for row in rows
    ]
    return MAPS.format(height=HEIGHT) + make_table(
        "| map | clip | found | kept | direction |", lines
    )


def _tell_shadow(row) -> str:
    line = f"| {row['largest_difference']:.4f} | {row['standard_error']:.4f} | {row['width_over_disk']:.3f} |"
    return SHADOW + make_table("| largest difference | standard error | width |", [line], 0)


def _tell_repair(rows) -> str:
    lines = [
        f"| {row['latitude']:g}° | {row['elevation_deg']:.1f}° | {row['clip']:g} | {row['from_noon_s'] / 60.0:.0f} min | "
        f"{row['minutes']:.2f} min | {row['width_minutes']:.1f} min | {row['sun_percent']:.3f} % | "
        f"{row['spread_percent']:.2f} % |"
        for row in sorted(rows, key=lambda row: -row["from_noon_s"])
    ]
    head = "| latitude | sun's height | clip | from noon | time off | stated width | sun off | stated |"
    return REPAIR.format(noon=NEAR_NOON / 60.0, low=LOW_SUN) + make_table(head, lines)


def _tell_noise(row) -> str:
    lines = [
        f"| {name} | {row[key]['mean']:.0f} lx | {row[key]['variance'] ** 0.5:.2f} lx | {row[key]['seconds']:.2f} s |"
        for key, name in (("map", "sun in the map"), ("lights", "sun as a light"))
    ]
    table = make_table("| sun | mean | standard error | time of the processors |", lines)
    return f"{NOISE}{table}\nVariance at equal time, with the sun in the map over as a light: {row['gain']:.2f}.\n"


def _tell_catchers(row) -> str:
    line = (
        f"| {row['unshadowed_change']:.1e} | {row['shadow_error_percent']:.3f} % | {row['direction_error_deg']:.3f}° | "
        f"{row['composite_error_percent']:.2f} % | {row['mirror_error_percent']:.2f} % | "
        f"{row['caustic_error_percent']:.2f} % |"
    )
    head = "| unshaded | shadows | sun by dragging | montage | mirror | caustic |"
    return CATCHERS + make_table(head, [line], 0)


def _tell_files(rows) -> str:
    lines = [
        f"| {row['file']} | {'refused' if row['refused'] else 'read'} | {row['said']} | {row['seconds']:.1f} s | "
        f"{row['peak_gb']:.1f} GB |"
        for row in rows
    ]
    return FILES + make_table("| file | | said | time | peak |", lines, 3)


def _tell_collection(rows) -> str:
    lines = []
    for row in rows:
        if "refused" in row:
            lines.append(f"| {row['file']} | {row['refused']} | | | | | |")
            continue
        sun = (
            "-"
            if row["sun_to_rest"] is None
            else f"{row['sun_to_rest']}, {row['sun_elevation_deg']:.1f}° high"
        )
        lines.append(
            f"| {row['file']} | {'; '.join(filter(None, (row['verdict'], row['remarks'])))} | {row['size']} | "
            f"{row['range']} | {row['horizontal_lx']:.0f} lx | {sun} | {row['error_percent']:.1e} % |"
        )
    head = "| picture | verdict | pixels | range | horizontal | sun : all else | kept |"
    return COLLECTION + make_table(head, lines, 2)
