"""The live view kept by light group: one view for each group, refined in turn, so that a mix needs no new samples."""

from dataclasses import dataclass, replace

import numpy as np

from ...accuracy.estimate import relative_error
from ...light_mix import LightMix, add_colours
from ...scene.camera import Camera
from ...scene.light_groups import WORLD
from ..compiled.compile import CompiledScene
from .film import GROUPS
from .live_view import LiveView, enlarge

GROUP_SEEDS = 1_000_003
"""Distance between the seeds of groups."""


@dataclass(eq=False)
class _Part:
    """A group's view.

    ``strengths``: what its choice of lights has learned, which is forgotten while others shine; ``error``: standard error of
    its luminance after its last pass, 0 while it is coarse, without what is seen of shadow catchers (h, w) [cd/m2];
    ``caught``: what both halves know of these.
    """

    name: str
    members: frozenset[str]
    view: LiveView
    strengths: np.ndarray | None = None
    error: np.ndarray | float = 0.0
    caught: np.ndarray | None = None
    passes: int = 0


class GroupedView:
    """Progressive pictures of a camera by light group, used like a `LiveView`; the groups share its samples.

    Parameters
    ----------
    scene : CompiledScene
    shares : list of (str, frozenset of str)    As of `light_groups.share_out`.
    camera : Camera
    settings : LiveSettings
    """

    def __init__(self, scene: CompiledScene, shares, camera: Camera, settings):
        self._scene = scene
        samples = max(settings.samples // len(shares), GROUPS)
        self._parts = []
        for number, (name, members) in enumerate(shares):
            seed = (settings.seed + GROUP_SEEDS * number) % 2**31
            scene.shine(members)
            view = LiveView(
                scene, camera, replace(settings, samples=samples, seed=seed), keeps_caught=True
            )
            self._parts.append(_Part(name, members, view))
        self._turn = 0

    words = ""
    """As of `LiveView`."""

    @property
    def factor(self) -> int:
        """By what the coarsest group's image is smaller than the view."""
        return max(part.view.factor for part in self._parts)

    @property
    def samples(self) -> int:
        """Samples of every pixel of all groups together, 0 while one is coarse."""
        samples = [part.view.samples for part in self._parts]
        return sum(samples) if all(samples) else 0

    @property
    def changes(self) -> int:
        """How often an image has changed."""
        return sum(part.view.changes for part in self._parts)

    @property
    def is_complete(self) -> bool:
        """Whether all samples were taken."""
        return all(part.view.is_complete for part in self._parts)

    def refine(self) -> bool:
        """Take one slice of samples, at first some for every group; true when a pass over a group's image was finished."""
        done = self._refine_one()
        while not all(part.passes for part in self._parts):
            # Without one of the groups the light would be another.
            done = self._refine_one()
        return done

    def mixed(self, levels: LightMix) -> tuple[np.ndarray, float]:
        """Return the sum of the groups at their levels, as of `LiveView.image`, and its relative error."""
        images = self._images()
        image = np.empty(images[0].shape, dtype=np.float32)
        colours = [each[..., :3] for each in images]
        layout = self._parts[0].view.caught_layout
        if layout is not None:
            caught = [each[..., self._parts[0].view.caught_columns] for each in images]
            shown = self._share_out(layout, [each.reshape(1, -1, layout.count) for each in caught])
            seen = ((each.tristimulus + each.change).reshape(colours[0].shape) for each in shown)
            colours = [own + more for own, more in zip(colours, seen, strict=True)]
        image[..., :3] = add_colours(colours, self._parts, levels)
        flux = [np.float32(levels.level(part.name).flux) for part in self._parts]
        image[..., 3:] = sum(k * each[..., 3:] for k, each in zip(flux, images, strict=True))
        if not self.samples:
            return image, float("inf")
        squares = sum((k * part.error) ** 2 for k, part in zip(flux, self._parts, strict=True))
        if layout is not None:
            shown = self._share_out(layout, [part.caught for part in self._parts])
            shared = sum(k * each.difference for k, each in zip(flux, shown, strict=True))
            squares = squares + shared.reshape(image.shape[:2]) ** 2
        return image, relative_error(image[..., 1], np.sqrt(squares))

    # ---- private ----

    def _share_out(self, layout, halves: list[np.ndarray]) -> list:
        """What each group gives to what is seen of shadow catchers, by what it knows of them: a `Shown` each."""
        return layout.share_out(halves, [WORLD in part.members for part in self._parts])[0]

    def _refine_one(self) -> bool:
        """Take one slice for the group whose turn it is; the next one has its turn when a pass is finished."""
        part = self._parts[self._turn]
        if self._scene.shine(part.members) and part.strengths is not None:
            self._scene.lights.set_strengths(part.strengths)
        done = not part.view.is_complete and part.view.refine()
        part.strengths = self._scene.lights.strengths if self._scene.lights.count else None
        if done:
            part.passes += 1
            if part.view.samples:
                part.error = part.view.luminance_error()
                part.caught = part.view.caught_halves()
        if done or part.view.is_complete:
            self._turn = (self._turn + 1) % len(self._parts)
        return done

    def _images(self) -> list[np.ndarray]:
        """Images of all groups in the size of the finest."""
        images = [part.view.image() for part in self._parts]
        size = max(image.shape[:2] for image in images)
        for number, image in enumerate(images):
            while image.shape[:2] != size:
                image = enlarge(image, size)  # noqa: PLW2901 - step by step
            images[number] = image
        return images
