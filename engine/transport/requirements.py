"""What a scene needs: the decisions, each with its reason."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..photometry.spectra import GRID, evaluate_emission
from ..scene.light import FormulaSky, ImageWorld, Luminaire, UniformWorld
from ..scene.memo import recall
from ..scene.scene import Scene
from ..scene.spectrum import Constant, Illuminant, Rgb
from ..scene.texture import ImageTexture
from ..sky.picture import WHITE


@dataclass(frozen=True)
class Requirements:
    """Decisions for one scene: ``spectral`` or photometric transport, dispersion, and why."""

    spectral: bool
    dispersive: bool
    reasons: tuple[str, ...]


def analyse(scene: Scene, transport: str = "auto") -> Requirements:
    """Decide how a scene has to be computed.

    Parameters
    ----------
    scene : Scene
    transport : str    ``auto``, ``mono`` or ``spectral``; the last two overrule the decision.

    Raises
    ------
    SceneError    ``transport`` is none of the three.
    """
    check_transport(transport)
    coloured = _first_coloured_material(scene)
    dispersive = any(material.surface.is_dispersive for material in met_materials(scene))
    lamps = _distinct_lamps(scene)
    reasons = []
    if coloured:
        reasons.append(f"material '{coloured}' has a reflectance that depends on the wavelength")
    if lamps > 1:
        reasons.append("the lights have different spectra")
    if any(_is_pictured(world) and _is_coloured(world.image) for world in worlds(scene)):
        reasons.append("the picture of the surroundings has colours")
    photos = [world.photo for world in worlds(scene) if world.photo is not None]
    if any(_is_coloured(photo.image) for photo in photos):
        reasons.append("the photo behind the scene has colours")
    if any(map(_has_colours, scene.lights.values())):
        reasons.append("a light has other colours in other directions")
    if dispersive:
        reasons.append("a glass disperses light")
    spectral = bool(reasons)
    if not spectral:
        reasons.append(
            "all surfaces are neutral and all lights share one spectrum: photometric transport is exact"
        )
    if transport != "auto" and spectral != (transport == "spectral"):
        verdict = "exact all the same" if transport == "spectral" else "an approximation here"
        reasons.append(f"the user asked for {transport} transport, which is {verdict}")
        spectral = transport == "spectral"
    return Requirements(spectral, dispersive and spectral, tuple(reasons))


def check_transport(transport: str) -> None:
    """Raise `SceneError` where a kind of transport is none of the three."""
    if transport not in ("auto", "mono", "spectral"):
        raise SceneError(f"transport is '{transport}', expected auto, mono or spectral")


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


def _distinct_lamps(scene: Scene) -> int:
    shapes = []
    for spectrum in dict.fromkeys(emission_spectra(scene)):
        values = evaluate_emission(spectrum, GRID)
        total = values.sum()
        if total <= 0.0:
            continue
        values = values / total
        if not any(np.allclose(values, other, rtol=1e-4, atol=1e-7) for other in shapes):
            shapes.append(values)
    patterned = any(
        material.emission is not None
        and material.emission.luminance > 0.0
        and _is_coloured(material.emission.pattern)
        for material in met_materials(scene)
    )
    return len(shapes) + patterned


def _has_colours(light) -> bool:
    return (
        isinstance(light, Luminaire)
        and light.output.value > 0.0
        and light.distribution.colours is not None
    )


def _is_pictured(world) -> bool:
    return isinstance(world, ImageWorld) and world.luminance_per_unit > 0.0


def _first_coloured_material(scene: Scene) -> str | None:
    for material in met_materials(scene):
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
