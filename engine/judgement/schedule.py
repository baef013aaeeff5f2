"""Schedule of luminaires: how many of each kind, their light, and the power that they take."""

from dataclasses import dataclass, field, replace

from ..luminaires.formats.record import LuminaireFile


@dataclass(frozen=True)
class Fitting:
    """Luminaires that are alike.

    Parameters
    ----------
    name : str    Of the luminaire as its file says, or of the file.
    luminous_flux : float    Of each as it is set. [lm]
    watts : float or None    Electrical, of each at full flux; None: its file does not say.
    count : int
    file : LuminaireFile or None    What describes it.
    """

    name: str
    luminous_flux: float
    watts: float | None
    count: int = 1
    file: LuminaireFile | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Schedule:
    """Luminaires of a scene.

    Parameters
    ----------
    fittings : tuple of Fitting    The largest shares of the flux first.
    """

    fittings: tuple[Fitting, ...]

    @property
    def count(self) -> int:
        """Of all luminaires."""
        return sum(each.count for each in self.fittings)

    @property
    def luminous_flux(self) -> float:
        """Of all. [lm]"""
        return sum(each.count * each.luminous_flux for each in self.fittings)

    @property
    def watts(self) -> float | None:
        """Installed; None if the power of any is not known. [W]"""
        if any(each.watts is None for each in self.fittings):
            return None
        return sum(each.count * each.watts for each in self.fittings)

    def power_density(self, area: float) -> float | None:
        """Return the installed power over a floor [m2]; None if a power is not known. [W/m2]"""
        watts = self.watts
        return None if watts is None else watts / area

    def relative_power(self, area: float, illuminance: float) -> float | None:
        """Return the installed power over a floor [m2] for every 100 lx of a mean illuminance [lx]. [W/m2 per 100 lx]"""
        density = self.power_density(area)
        return None if density is None else 100.0 * density / illuminance


def make_schedule(luminaires) -> Schedule:
    """Count luminaires that have the same name, flux (to a tenth of a per mille) and power.

    Parameters
    ----------
    luminaires : iterable of Fitting
    """
    kinds: dict[tuple, Fitting] = {}
    for each in luminaires:
        key = (each.name, f"{each.luminous_flux:.4g}", each.watts)
        known = kinds.get(key)
        count = each.count + (known.count if known else 0)
        kinds[key] = replace(known or each, count=count)
    order = sorted(kinds.values(), key=lambda kind: (-kind.count * kind.luminous_flux, kind.name))
    return Schedule(tuple(order))
