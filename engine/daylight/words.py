"""Figures of a year in words, for a terminal and for Blender's texts."""

from .light import Light
from .study import Figures, Question

METHODS = {"factors": "EN 17037 by factors", "illuminances": "EN 17037 by hours"}


def describe(light: Light, figures: Figures, question: Question) -> list[tuple[str, list[str]]]:
    """Return labels and lines."""
    place = light.year.weather.place
    schedule = question.schedule
    rows = [
        ("place", [f"{place.name} ({place.latitude:.2f}, {place.longitude:.2f})"]),
        ("hours", [f"{schedule.start:g} to {schedule.end:g} h of {question.zone or place.zone}"]),
        (
            "daylight factor",
            [
                f"median {_share(figures, 'daylight_factor_median')}",
                f"mean {_share(figures, 'daylight_factor_mean')}",
            ],
        ),
        ("mean illuminance", [_lux(figures, "mean_lx")]),
        (f"autonomy {question.target:g} lx", [_share(figures, "daylight_autonomy")]),
        ("sDA 300/50 %", [_share(figures, "sda")]),
        ("ASE 1000, 250 h", [_share(figures, "ase")]),
    ]
    closed = [100.0 * float(group.mean()) for group in figures.is_closed]
    if closed:
        rows.append(("blinds closed", [f"{each:.3g} % of the hours with light" for each in closed]))
    for method, label in METHODS.items():
        found = figures.provision.get(method)
        if found is not None:
            rows.append((label, [_level(found)]))
    if figures.sunlight_level:
        hours = float(figures.sensors["sunlight_of_day_h"].value.max(initial=0.0))
        rows.append(("sunlight", [f"{figures.sunlight_level}, {hours:.1f} h at the best sensor"]))
    rows.append(("probability", ["intervals hold the true values with 95 %"]))
    return rows


def _share(figures: Figures, name: str) -> str:
    """A share with its interval, which ends where shares do."""
    value, (low, high) = figures.area[name].value, figures.area[name].interval()
    value, low, high = (100.0 * float(each) for each in (value, low, high))
    if name in ("sda", "ase", "daylight_autonomy"):
        high = min(high, 100.0)
    return f"{value:.3g} %, between {max(low, 0.0):.3g} % and {high:.3g} %"


def _lux(figures: Figures, name: str) -> str:
    value, (low, high) = figures.area[name].value, figures.area[name].interval()
    return f"{float(value):.4g} lx, between {float(low):.4g} and {float(high):.4g} lx"


def _level(found) -> str:
    if found.lowest == found.highest:
        return found.level
    return f"{found.level}, between {found.lowest} and {found.highest} by the noise"
