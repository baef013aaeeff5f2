"""What a scene holds, as far as decisions ask for it."""

from functools import cached_property

import numpy as np

from ..photometry.spectra import GRID, evaluate_emission
from ..scene.light import FormulaSky, ImageWorld, Luminaire, UniformWorld
from ..scene.memo import recall
from ..scene.scene import Scene
from ..scene.spectrum import Constant, Illuminant, Rgb
from ..scene.texture import ImageTexture
from ..sky.picture import WHITE


class Facts:
    """What a scene holds; found once, when it is asked for first.

    Parameters
    ----------
    scene : Scene    Must not change while this object is used.
    is_spectral : bool    Whether light has wavelengths, once that is decided.
    """

    def __init__(self, scene: Scene, is_spectral: bool = True):
        self.scene, self.is_spectral = scene, is_spectral

    @cached_property
    def materials(self) -> tuple:
        """What light and the camera meet."""
        return tuple(met_materials(self.scene))

    @property
    def surfaces(self) -> tuple:
        """What the materials are."""
        return tuple(material.surface for material in self.materials)

    @cached_property
    def lamps(self) -> tuple:
        """Spectra of everything that emits, none twice."""
        return tuple(dict.fromkeys(emission_spectra(self.scene)))

    @cached_property
    def has_diffuse(self) -> bool:
        """Whether a surface is matt, with or without a coat."""
        coated = [surface.as_coated for surface in self.surfaces]
        return any(each is not None and each.base_roughness <= 0.0 for each in coated)

    @cached_property
    def is_dispersive(self) -> bool:
        """Whether a surface refracts light by its wavelength."""
        return any(surface.is_dispersive for surface in self.surfaces)

    @cached_property
    def coloured_light_reasons(self) -> tuple[str, ...]:
        """Why light has other colours at other places or in other directions."""
        told = []
        seen = worlds(self.scene)
        if any(_is_pictured(world) and _is_coloured(world.image) for world in seen):
            told.append("the picture of the surroundings has colours")
        if any(_is_coloured(world.photo.image) for world in seen if world.photo is not None):
            told.append("the photo behind the scene has colours")
        if any(map(_has_colours, self.scene.lights.values())):
            told.append("a light has other colours in other directions")
        return tuple(told)

    @property
    def has_coloured_lights(self) -> bool:
        """Whether a light has no single spectrum."""
        return bool(self.coloured_light_reasons) or _has_patterns(self.materials)

    @cached_property
    def spectral_reasons(self) -> tuple[str, ...]:
        """Why light needs wavelengths to be exact; empty if it needs none."""
        coloured = _first_coloured(self.materials)
        told = []
        if coloured:
            told.append(f"material '{coloured}' has a reflectance that depends on the wavelength")
        if _count_lamps(self.lamps) + _has_patterns(self.materials) > 1:
            told.append("the lights have different spectra")
        told += self.coloured_light_reasons
        if self.is_dispersive:
            told.append("a glass disperses light")
        return tuple(told)


def used_materials(scene: Scene):
    """Yield the materials that some mesh refers to, in a fixed order."""
    used = {key for mesh in scene.meshes.values() for key in mesh.materials}
    for key in sorted(used):
        if key in scene.materials:
            yield scene.materials[key]


def met_materials(scene: Scene):
    """Yield what light and the camera meet of the materials in use, in a fixed order."""
    for material in used_materials(scene):
        yield material
        if material.seen is not None:
            yield material.seen


def worlds(scene: Scene) -> list:
    """Worlds that light surfaces and that the camera sees."""
    world = scene.world
    return [each for each in (world, world and world.seen) if each is not None]


def emission_spectra(scene: Scene) -> list:
    """Return the spectra of everything that emits."""
    found = [light.output.spectrum for light in scene.lights.values() if light.output.value > 0.0]
    for material in met_materials(scene):
        if material.emission is not None and material.emission.luminance > 0.0:
            found.append(material.emission.spectrum)
    for world in worlds(scene):
        if isinstance(world, UniformWorld) and world.luminance > 0.0:
            found.append(world.spectrum)
        if isinstance(world, FormulaSky) and world.illuminance > 0.0:
            found.append(world.spectrum)
        # The colours of a picture or a photo are told apart from this.
        if _is_pictured(world) or world.photo is not None:
            found.append(Illuminant(WHITE))
    return found


def _count_lamps(spectra) -> int:
    """How many spectra differ by more than rounding."""
    shapes = []
    for spectrum in spectra:
        values = evaluate_emission(spectrum, GRID)
        total = values.sum()
        if total <= 0.0:
            continue
        values = values / total
        if not any(np.allclose(values, other, rtol=1e-4, atol=1e-7) for other in shapes):
            shapes.append(values)
    return len(shapes)


def _has_patterns(materials) -> bool:
    """Whether a surface glows in other colours at other places."""
    return any(
        material.emission is not None
        and material.emission.luminance > 0.0
        and _is_coloured(material.emission.pattern)
        for material in materials
    )


def _has_colours(light) -> bool:
    return (
        isinstance(light, Luminaire)
        and light.output.value > 0.0
        and light.distribution.colours is not None
    )


def _is_pictured(world) -> bool:
    return isinstance(world, ImageWorld) and world.luminance_per_unit > 0.0


def _first_coloured(materials) -> str | None:
    for material in materials:
        surface = material.surface
        if surface.has_own_colour or any(map(_is_coloured, surface.colours)):
            return material.name
    return None


def _is_coloured(value) -> bool:
    match value:
        case None | Constant():
            return False
        case Rgb():
            return not (value.red == value.green == value.blue)
        case ImageTexture():
            return value.pixels.shape[2] == 3 and recall(
                value.pixels, "coloured", lambda pixels: spread(pixels) > 1e-4
            )
    return True


def spread(pixels: np.ndarray) -> float:
    """Largest difference between the channels of a picture's pixel; those that are no finite numbers have none."""
    largest, smallest = pixels[..., 0], pixels[..., 0]
    for channel in range(1, pixels.shape[2]):
        # Much faster than along the last axis, which is very short.
        largest = np.maximum(largest, pixels[..., channel])
        smallest = np.minimum(smallest, pixels[..., channel])
    with np.errstate(invalid="ignore"):
        return float(np.fmax.reduce(largest - smallest, axis=None))


def is_coloured(surface) -> bool:
    """Tell whether a surface has a spectrum, pictures aside, that depends on the wavelength."""
    return surface.has_own_colour or any(
        _is_coloured(value) for value in surface.colours if not isinstance(value, ImageTexture)
    )


def pictures(material):
    """Yield every picture that a material uses, in a fixed order."""
    yield from material.surface.pictures
    if material.emission is not None and material.emission.pattern is not None:
        yield material.emission.pattern
