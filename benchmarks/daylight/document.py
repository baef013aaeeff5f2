"""The document of the benchmark of daylight, made of its numbers."""

from ..common.bars import Bar
from ..common.document import BEARABLE_LOAD, make_table, tell_demands
from .skies import AZIMUTH, ELEVATION
from .speed import OURS, TARGET, find_times, speedup

SUN, SKY = 0.02, 0.5
"""Most that positions [degree] and skies [%] may be off."""

BIAS, COVER, FASTER, HOURS_WORTH = 0.5, (0.90, 0.99), 50.0, 3.0
"""Most bias of hours [%], range of the share of intervals that hold, least speed over Radiance, most cost over an hour."""

TITLE = """# Daylight

*Made by `lumenray benchmark daylight`; do not edit by hand.*

The sun's place, skies and the year of one room beside other programs. Weather of the year: {weather}.
{cpu}, {cores} cores; Mitsuba {mitsuba}, Lumenray {lumenray}. To repeat it:
`lumenray benchmark daylight --json out/daylight.json`; parts by themselves with `--parts sun,skies,year,speed,scale`.

"""

SUN_TEXT = """## The sun

{count} random places and times of 1950 to 2050, evenly over the Earth's surface, day and night: angle between the direction
here (NREL's algorithm, without refraction) and that of two independent ones. Meeus' shorter theory is exact to 0.01° and
leaves out the parallax, at most 0.0024°; Michalsky's algorithm, which `gensky -y` has, states 0.01° for these years. Where
the sun is higher than 86.9°, `gensky` moves it, and it is left out.

"""

SKIES_TEXT = """## Skies

The formulas that Radiance's programs hand to a scene, with the numbers they print, by `rcalc` at the middles of cells of
half a degree; *luminance*: largest difference over all cells after both are brought to the same level by the same sum.
*illuminance*: the horizontal illuminance here over what Radiance's program aims at. *given*: what Radiance's sky gives by
that sum over what it aims at. `gendaylit` levels by a mean over 145 directions and `gensky` by a fit in place of the
integral, so their skies give another illuminance than they were told; here it is the integral.

The sun of `gensky`'s skies stands at {elevation:g}°, azimuth {azimuth:g}°. The CIE has no intermediate sky: it is a measured
sky here, of a table of luminances every degree.

"""

YEAR_TEXT = """## The year

A room of 5 m by 8 m with 200 sensors at 0.8 m, a window with glass in its south wall and an overhang before it, over a
ground that reflects 20 %.

"""

SPEED_TEXT = """## Speed against error

*noise*: of one run, by the difference of two. *error*: noise and what the method leaves out, against {hours} hours that were
computed by themselves. Both are root mean squares over the hours, over the sensor's mean, and of that over sensors. Seconds
are those of the processors.

"""


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    parts = result["parts"]
    skies = parts.get("skies")
    gensky = skies and 100.0 * max(
        max(row["luminance"], abs(row["illuminance"])) for row in skies["gensky"].values()
    )
    cover, race = result["metric_coverage"], "speed" in parts and speedup(parts["speed"])
    against = f" ({race[1]}, by its {race[2]})" if race else ""
    return [
        _below("sun's place, largest difference", result["sun_max_error_deg"], SUN, "°", 4),
        _below("skies of gensky, largest difference", gensky, SKY, " %", 3),
        _below(
            "hours of gendaylit, largest difference", result["gendaylit_max_percent"], SKY, " %", 3
        ),
        _below("bias of the year beside its hours", result["hour_bias_percent"], BIAS, " %", 2),
        Bar(
            "intervals of 95 % of metrics that hold",
            f"{COVER[0]:.0%} to {COVER[1]:.0%}",
            "-" if cover is None else f"{cover:.1%}",
            None if cover is None else COVER[0] <= cover <= COVER[1],
        ),
        Bar(
            f"two-phase chain over ours, time to {TARGET:.0%}",
            f"at least {FASTER:g}",
            f"{race[0]:.3g}{against}" if race else "-",
            race[0] >= FASTER if race else None,
        ),
        _below(
            "a year over an hour, time to the same error",
            result["year_over_hour"],
            HOURS_WORTH,
            "",
            2,
        ),
    ]


def _below(demand: str, value: float | None, limit: float, unit: str, digits: int) -> Bar:
    if value is None:
        return Bar(demand, f"at most {limit:g}{unit}", "-", None)
    return Bar(demand, f"at most {limit:g}{unit}", f"{value:.{digits}f}{unit}", value <= limit)


def describe(result: dict) -> str:
    """Return the document."""
    parts = result["parts"]
    text = TITLE.format(weather=_named(result["weather"]), **result["machine"])
    if "sun" in parts:
        text += SUN_TEXT.format(count=parts["sun"]["count"]) + _tell_sun(parts["sun"])
    if "skies" in parts:
        text += SKIES_TEXT.format(elevation=ELEVATION, azimuth=AZIMUTH) + _tell_skies(
            parts["skies"]
        )
    if "year" in parts:
        text += YEAR_TEXT + _tell_year(parts["year"])
    if "speed" in parts:
        hours = len(parts["speed"]["truth"]["hours"])
        text += SPEED_TEXT.format(hours=hours) + _tell_speed(parts["speed"])
    if "scale" in parts:
        text += _tell_scale(parts["scale"])
    busy = {
        name: load for name, load in result["other_load"].items() if (load or 0.0) > BEARABLE_LOAD
    }
    if busy.keys() & {"year", "speed", "scale"}:
        shares = ", ".join(f"{name} {load:.0%}" for name, load in busy.items())
        text += f"Other processes took part of the machine meanwhile: {shares}.\n\n"
    return text + tell_demands(check_bars(result))


def _named(weather: str) -> str:
    return (
        "a year that is made up by a Markov chain of clear, broken and overcast days (38.7° N, 9.1° W)"
        if weather == "made up"
        else f"`{weather}`"
    )


def _tell_sun(made: dict) -> str:
    rows = [
        f"| {name} | {row['count']} | {row['rms']:.4f}° | {row['max']:.4f}° | {row['worst']} |"
        for name, row in made["others"].items()
    ]
    return make_table("| against | compared | rms | largest | there |", rows) + "\n"


def _tell_skies(made: dict) -> str:
    rows = [
        f"| {name} | {100 * row['luminance']:.3f} % | {100 * row['illuminance']:+.3f} % | {100 * row['given']:.2f} % |"
        for name, row in made["gensky"].items()
    ]
    text = make_table("| gensky | luminance | illuminance | given |", rows)
    rows = [
        f"| {row['class']} | {row['elevation']:.0f}° | {row['direct']:.0f} | {row['diffuse']:.0f} | "
        f"{100 * row['luminance']:.3f} % | {100 * row['illuminance']:+.3f} % | {100 * row['sun']:+.3f} % | "
        f"{100 * row['given']:.2f} % |"
        for row in sorted(made["gendaylit"], key=lambda row: (row["class"], row["elevation"]))
    ]
    head = "| class | sun | direct [W/m²] | diffuse [W/m²] | luminance | illuminance | by the sun | given |"
    return f"{text}\n{make_table(head, rows, 0)}\n"


def _tell_year(made: dict) -> str:
    own, cover, cost = made["agreement"], made["coverage"], made["cost"]
    text = (
        f"**{own['hours']} hours by themselves.** The year's mean is {100 * own['bias']:+.3f} % off theirs, with a standard "
        f"error of {100 * own['bias_error']:.3f} %. Of all hours and sensors {100 * own['within_2']:.1f} % lie within two "
        f"joint standard errors; root mean square {own['rms']:.2f}, farthest {own['farthest']:.1f} of them.\n\n"
        f"**Stated errors of metrics,** {cover['seeds']} seeds:\n\n"
    )
    rows = [
        f"| {name} | {row['count']} | "
        + " | ".join(f"{100 * x:.1f} %" for x in row["cover"])
        + " |"
        for name, row in cover["metrics"].items()
    ]
    means = " | ".join(f"**{100 * x:.1f} %**" for x in cover["cover"])
    heads = " | ".join(f"hold with {amount} paths" for amount in cover["amounts"])
    text += make_table(f"| metric | intervals | {heads} |", [*rows, f"| mean | | {means} |"])
    rows = [
        f"| {year[0]:.1f} s | {100 * year[1]:.2f} % | {hour[0]:.1f} s | {100 * hour[1]:.2f} % |"
        for year, hour in zip(cost["year"], cost["hour"], strict=True)
    ]
    text += f"\n**Cost,** of the processors:\n\n{make_table('| year | error | an hour | error |', rows, 0)}\n"
    return text + (
        f"To an error of 2 % a year takes {cost['year_seconds']:.3g} s and an hour {cost['hour_seconds']:.3g} s.\n\n"
    )


def _tell_speed(made: dict) -> str:
    rows = [
        f"| {name} | {row['work']} | {row['seconds']:.2f} | {100 * row['noise']:.2f} % | {100 * row['error']:.2f} % |"
        for name, runs in made["runs"].items()
        for row in runs
    ]
    text = make_table("| | work | seconds | noise | error |", rows, 2)
    times = find_times(made)
    rows = [
        f"| {name} | {_tell_time(row['noise'])} | {_tell_time(row['error'])} |"
        for name, row in times.items()
    ]
    text += f"\n{make_table(f'| seconds to {TARGET:.0%} | by noise | by error |', rows)}\n"
    text += f"Radiance's exact sun by itself takes {made['sun_seconds']:.2f} s.\n\n"
    race = speedup(made)
    if race is None:
        missing = OURS if OURS not in times else "any"
        return (
            text
            + f"There is no ratio, as {missing} was not measured or does not come down to it.\n\n"
        )
    return (
        text
        + f"The fastest chain of Radiance, {race[1]}, takes {race[0]:.3g} times as long by its {race[2]}.\n\n"
    )


def _tell_time(reach: dict | None) -> str:
    if reach is None:
        return "not reached"
    return f"{reach['bound']}{reach['seconds']:.3g}" + (
        " (beyond the runs)" if reach["beyond"] else ""
    )


def _tell_scale(made: dict) -> str:
    return (
        f"## Many sensors\n\n{made['sensors']} sensors on {made['cores']} cores take {made['minutes']:.1f} minutes "
        f"({made['processor_minutes']:.1f} of the processors) with {made['samples']} paths each; stated error "
        f"{100 * made['error']:.1f} %.\n\n"
    )
