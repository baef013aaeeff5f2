"""The materials that the engine has, and which of them may be out of date."""

from dataclasses import dataclass, field

import bpy

from ....engine.scene.material import Material
from ....engine.scene.scene import content_digest
from ....engine.scene.spectrum import Rgb
from ...foundation.identity import engine_id
from ...foundation.report import ConversionReport
from ..coloured_light import colour_of_light, paints_of
from ..displacement import displaces
from ..images.cache import ImageCache
from ..lights.portals import portal_material
from ..materials.materials import convert_material, default_material
from ..nodes.dependencies import shading_dependencies
from .pictures import PictureTable

DEFAULT_MATERIAL = "material:"
"""Id of what surfaces without a material are made of."""


@dataclass
class _Entry:
    """What is known of one material of Blender, by its session uid."""

    key: str
    name: str = ""
    is_stale: bool = True
    digest: bytes = b""
    is_luminous: bool = False
    paints: tuple[Rgb, ...] = ()
    glow: Rgb | None = None
    has_pictures: bool = False
    displaces: bool = False
    version: int = 0
    dependencies: frozenset[int] = frozenset()
    report: ConversionReport = field(default_factory=ConversionReport)


class MaterialTable:
    """Materials by id; converted when they are first used and when something behind them changed.

    Parameters
    ----------
    images : ImageCache    What was read of images before.
    pictures : PictureTable    What the engine has of them.
    is_patient : bool    Whether to wait for scattering files that are being read.

    Attributes
    ----------
    efficacy, metres : float    As of `convert_material`.
    """

    def __init__(self, images: ImageCache, pictures: PictureTable, is_patient: bool = True):
        self.efficacy, self.metres = 0.0, 1.0
        self._images, self._pictures, self._is_patient = images, pictures, is_patient
        self.changed: list[Material] = []
        self.removed: list[str] = []
        self._entries: dict[int, _Entry] = {}
        self._reshaping: set[str] = set()

    def mark(self, tagged: set[int]) -> None:
        """Note that materials which are or read one of these data-blocks may be out of date."""
        for session_uid, entry in self._entries.items():
            if session_uid in tagged or not entry.dependencies.isdisjoint(tagged):
                entry.is_stale = True

    def mark_all(self) -> None:
        """Note that all of them may be out of date."""
        for session_uid, entry in self._entries.items():
            entry.is_stale = session_uid > 0

    def use(self, material, depsgraph) -> str:
        """Return the id of a material (None: what stands for a missing one); it is converted if it is new."""
        if material is None:
            return self._take_made(0, default_material(DEFAULT_MATERIAL))
        original = material.original
        session_uid = original.session_uid
        entry = self._entries.get(session_uid)
        if entry is None:
            entry = self._entries[session_uid] = _Entry(engine_id(original))
            self._update(original, entry, depsgraph)
        return entry.key

    def version(self, material) -> int:
        """Return how often a material in use has been converted."""
        return self._entries[material.original.session_uid].version

    def take_reshaping(self) -> set[str]:
        """Return the ids of materials that displace meshes, or did, and were converted since the last time."""
        found, self._reshaping = self._reshaping, set()
        return found

    def use_portal(self) -> str:
        """Return the id of what portals are made of."""
        return self._take_made(-1, portal_material())

    def _take_made(self, number: int, made: Material) -> str:
        """Return the id of a material that is none of Blender's; ``number``: in place of a session uid, 0 or less."""
        if number not in self._entries:
            self._entries[number] = _Entry(made.id, made.name, False, content_digest(made))
            self.changed.append(made)
        return made.id

    def refresh(self, used: set[str], depsgraph) -> None:
        """Convert what is out of date among the materials in use; give up those that Blender has no more."""
        stale = [
            key for key, entry in self._entries.items() if entry.is_stale and entry.key in used
        ]
        unused = [key for key, entry in self._entries.items() if entry.key not in used]
        if not stale and not unused:
            return
        blocks = {block.session_uid: block for block in bpy.data.materials}
        for session_uid in stale:
            if session_uid in blocks:
                self._update(blocks[session_uid], self._entries[session_uid], depsgraph)
        for session_uid in unused:
            if session_uid not in blocks or not blocks[session_uid].users:
                key = self._entries.pop(session_uid).key
                self._pictures.drop(key)
                self.removed.append(key)

    def flush(self) -> tuple[list[Material], list[str]]:
        """Hand over what changed and what was removed since the last time."""
        made, gone = self.changed, self.removed
        self.changed, self.removed = [], []
        return made, gone

    def tell(self, used: set[str]) -> tuple[list[ConversionReport], bool]:
        """Return the reports of the materials in use, and whether one of them is luminous."""
        entries = [entry for entry in self._entries.values() if entry.key in used]
        return [entry.report for entry in entries], any(entry.is_luminous for entry in entries)

    def colours(self, used: set[str]) -> tuple[list, list]:
        """Colours of the light that materials in use give, None of white, and of what they reflect, each with a name."""
        entries = [entry for entry in self._entries.values() if entry.key in used]
        glows = [(entry.name, entry.glow) for entry in entries if entry.is_luminous]
        return glows, [(entry.name, paint) for entry in entries for paint in entry.paints]

    def is_luminous(self, keys) -> bool:
        """Whether one of the materials with these ids glows."""
        return any(entry.is_luminous for entry in self._entries.values() if entry.key in keys)

    def has_pictures(self, keys) -> bool:
        """Whether one of the materials with these ids varies over the surface."""
        return any(entry.has_pictures for entry in self._entries.values() if entry.key in keys)

    def luminous(self) -> list[tuple[str, str]]:
        """Return ids and names of the materials that glow."""
        return [(entry.key, entry.name) for entry in self._entries.values() if entry.is_luminous]

    def dependencies(self) -> set[int]:
        """Return session uids of all node trees and images that the materials read."""
        return set().union(*(entry.dependencies for entry in self._entries.values()))

    def __iter__(self):
        """Ids of the materials that the engine has."""
        return (entry.key for entry in self._entries.values())

    def _update(self, block, entry, depsgraph) -> None:
        entry.report = ConversionReport()
        # In the frames of a render only the evaluated one has what is animated.
        made = convert_material(
            block.evaluated_get(depsgraph),
            entry.key,
            entry.report,
            self.efficacy,
            self._images,
            self._is_patient,
            self.metres,
        )
        entry.is_stale, entry.name = False, made.name
        entry.version += 1
        did, entry.displaces = entry.displaces, displaces(block)
        if did or entry.displaces:
            self._reshaping.add(entry.key)
        entry.dependencies = shading_dependencies(block)
        entry.is_luminous = made.emission is not None and made.emission.luminance > 0.0
        entry.paints, entry.glow = paints_of(made), colour_of_light(made)
        entry.has_pictures = bool(made.surface.pictures)
        if made.emission is not None:
            entry.has_pictures |= made.emission.pattern is not None
        digest = content_digest(made)
        if digest != entry.digest:
            entry.digest = digest
            self.changed.append(self._pictures.put(made))
