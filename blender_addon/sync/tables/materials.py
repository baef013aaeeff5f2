"""The materials that the engine has, and which of them may be out of date."""

from dataclasses import dataclass, field

from ....engine.scene.material import Material
from ....engine.scene.scene import content_digest
from ....engine.scene.spectrum import Rgb
from ...foundation.identity import engine_id, members
from ...foundation.report import ConversionReport
from ..coloured_light import colour_of_light, paints_of
from ..displacement import displaces
from ..images.cache import ImageCache
from ..lights.portals import portal_material
from ..materials.materials import convert_material, default_material, material_context
from ..nodes.dependencies import shading_dependencies
from ..nodes.needs import SURFACE, all_needs
from ..placing import Place
from .pictures import PictureTable
from .placed import LIVE_TEXELS, MOST, TEXELS, Placed, convert_for, pictures_of, shares

DEFAULT_MATERIAL = "material:"
"""Id of what surfaces without a material are made of."""


@dataclass
class _Entry:
    """What is known of one material of Blender, by its session uid.

    ``needs``: what it would have to know of an object, as `nodes.needs` has them; ``version``: how often it was converted;
    ``waiting``: what of it the engine lacks; ``is_sent``: whether that has it in some form;
    ``is_crowded``: whether it was asked for by more objects than it is made for.
    """

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
    needs: frozenset[tuple] = frozenset()
    waiting: Material | None = None
    is_sent: bool = False
    is_crowded: bool = False
    report: ConversionReport = field(default_factory=ConversionReport)


class MaterialTable:
    """Materials by id; converted when they are first used and when something behind them changed.

    Parameters
    ----------
    images : ImageCache    What was read of images before.
    pictures : PictureTable    What the engine has of them.
    is_patient : bool    Whether to wait for scattering files that are being read.
    texels : int or None    Of all pictures that are made for single objects; None: as many as usual.

    Attributes
    ----------
    efficacy, metres : float    As of `convert_material`.
    """

    def __init__(
        self,
        images: ImageCache,
        pictures: PictureTable,
        is_patient: bool = True,
        texels: int | None = None,
    ):
        self.efficacy, self.metres = 0.0, 1.0
        self._images, self._pictures, self._is_patient = images, pictures, is_patient
        self._texels = texels or (TEXELS if is_patient else LIVE_TEXELS)
        self.changed: list[Material] = []
        self.removed: list[str] = []
        self.remade = 0
        self._entries: dict[int, _Entry] = {}
        self._reshaping: set[str] = set()
        self._placed: dict[str, Placed] = {}
        self._used: set[str] = set()

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
            entry = self._entries[session_uid] = self._successor(engine_id(original))
            self._update(original, entry, depsgraph)
        return entry.key

    def _successor(self, key: str) -> _Entry:
        """Begin with a material; one that had its id before, as the last copy that a preview showed, gives it up."""
        number = next((n for n, entry in self._entries.items() if entry.key == key), None)
        if number is None:
            return _Entry(key)
        before = self._entries.pop(number)
        return _Entry(key, digest=before.digest, is_sent=before.is_sent, version=before.version)

    def version(self, material) -> int:
        """Return how often a material in use has been converted."""
        return self._entries[material.original.session_uid].version

    def take_reshaping(self) -> set[str]:
        """Return the ids of materials that displace meshes, or did, and were converted since the last time."""
        found, self._reshaping = self._reshaping, set()
        return found

    def needs(self, material) -> frozenset[tuple]:
        """Return what a material that was `use`d would have to know of an object (None: nothing)."""
        return (
            frozenset() if material is None else self._entries[material.original.session_uid].needs
        )

    def place(self, material, place: Place) -> str:
        """Return the id of a material for one object; that for all where it is made for too many."""
        owner = material.original.session_uid
        known = self._placed.get(place.key)
        if known is None:
            if sum(each.owner == owner for each in self._placed.values()) >= MOST:
                self._entries[owner].is_crowded = True
                return self._entries[owner].key
            known = self._placed[place.key] = Placed(place, owner)
        known.place, known.owner = place, owner
        return place.key

    def use_portal(self) -> str:
        """Return the id of what portals are made of."""
        return self._take_made(-1, portal_material())

    def _take_made(self, number: int, made: Material) -> str:
        """Return the id of a material that is none of Blender's; ``number``: in place of a session uid, 0 or less."""
        if number not in self._entries:
            self._entries[number] = _Entry(made.id, made.name, False, content_digest(made))
            self._entries[number].waiting = made
        return made.id

    def renew(self, used: set[str], depsgraph) -> bool:
        """Convert what is out of date among the materials in use; return whether one needs other things of objects."""
        used = used | {
            self._entries[self._placed[key].owner].key for key in used if key in self._placed
        }
        stale = [
            key for key, entry in self._entries.items() if entry.is_stale and entry.key in used
        ]
        blocks = _blocks(depsgraph) if stale else {}
        is_other = False
        for session_uid in stale:
            if session_uid in blocks:
                entry = self._entries[session_uid]
                before = entry.needs
                self._update(blocks[session_uid], entry, depsgraph)
                is_other |= entry.needs != before
        return is_other

    def refresh(self, used: set[str], depsgraph) -> None:
        """Convert what is out of date among the materials in use; give up those that Blender has no more."""
        self.renew(used, depsgraph)
        self._used = used
        self._refresh_placed(used, depsgraph)
        for entry in self._entries.values():
            # What is made for objects one by one is not sent for all of them as well.
            if entry.waiting is not None and (entry.key in used or not entry.needs):
                self.changed.append(self._pictures.put(entry.waiting))
                entry.waiting, entry.is_sent = None, True
        owners = {placed.owner for placed in self._placed.values()}
        unused = [
            key
            for key, entry in self._entries.items()
            if entry.key not in used and key not in owners
        ]
        if not unused:
            return
        blocks = _blocks(depsgraph)
        for session_uid in unused:
            if session_uid not in blocks or not blocks[session_uid].users:
                entry = self._entries.pop(session_uid)
                if entry.is_sent:
                    self._pictures.drop(entry.key)
                    self.removed.append(entry.key)

    def _refresh_placed(self, used: set[str], depsgraph) -> None:
        """Convert what is out of date among the materials for single objects; give up those that nothing shows."""
        for key in [key for key in self._placed if key not in used]:
            if self._placed.pop(key).digest:
                self._pictures.drop(key)
                self.removed.append(key)
        if not self._placed:
            return
        blocks = _blocks(depsgraph)
        share = shares(self._texels, {key: placed.place for key, placed in self._placed.items()})
        for key, placed in self._placed.items():
            version = self._entries[placed.owner].version
            # A step of two along a side for every one of four in the share, so that few others change with one.
            steps = share.get(key, 1).bit_length() // 2
            made_of = (*placed.place.state(), version, steps)
            self.remade += made_of[2:4] != placed.made_of[2:4]
            if made_of != placed.made_of and placed.owner in blocks:
                self._update_placed(placed, blocks[placed.owner], 4**steps, depsgraph)
                placed.made_of = made_of

    def _update_placed(self, placed: Placed, block, share: int, depsgraph) -> None:
        placed.report = ConversionReport()
        made = convert_for(
            placed.place,
            share,
            block.evaluated_get(depsgraph),
            placed.report,
            self.efficacy,
            self._images,
            self._is_patient,
            self.metres,
        )
        placed.name = made.name
        placed.is_luminous = _is_luminous(made)
        placed.paints, placed.glow = paints_of(made), colour_of_light(made)
        digest = content_digest(made)
        if digest != placed.digest:
            placed.digest = digest
            self.changed.append(self._pictures.put(made))

    def flush(self) -> tuple[list[Material], list[str]]:
        """Hand over what changed and what was removed since the last time."""
        made, gone = self.changed, self.removed
        self.changed, self.removed, self.remade = [], [], 0
        return made, gone

    def tell(self, used: set[str]) -> tuple[list[ConversionReport], bool]:
        """Return the reports of the materials in use, and whether one of them is luminous."""
        entries = [entry for key, entry in self._all() if key in used]
        reports = [entry.report for entry in entries]
        reports += [
            _tell_crowd(e) for e in self._entries.values() if e.key in used and e.is_crowded
        ]
        return reports, any(entry.is_luminous for entry in entries)

    def colours(self, used: set[str]) -> tuple[list, list]:
        """Colours of the light that materials in use give, None of white, and of what they reflect, each with a name."""
        entries = [entry for key, entry in self._all() if key in used]
        glows = [(entry.name, entry.glow) for entry in entries if entry.is_luminous]
        return glows, [(entry.name, paint) for entry in entries for paint in entry.paints]

    def is_luminous(self, materials) -> bool:
        """Whether one of these materials, which were `use`d, glows."""
        return any(entry.is_luminous for entry in self._entries_of(materials))

    def has_pictures(self, materials) -> bool:
        """Whether one of these materials, which were `use`d, varies over surfaces as UV maps have it."""
        return any(entry.has_pictures for entry in self._entries_of(materials))

    def _entries_of(self, materials) -> list[_Entry]:
        numbers = (0 if each is None else each.original.session_uid for each in materials)
        return [self._entries[number] for number in numbers]

    def luminous(self) -> list[tuple[str, str]]:
        """Return ids and names of the materials that glow."""
        return [
            (key, entry.name)
            for key, entry in self._all()
            if entry.is_luminous and (key in self._used or not getattr(entry, "needs", None))
        ]

    def _all(self):
        """Ids and what is known of all materials, those for single objects included."""
        yield from ((entry.key, entry) for entry in self._entries.values())
        yield from self._placed.items()

    def dependencies(self) -> set[int]:
        """Return session uids of all node trees and images that the materials read."""
        return set().union(*(entry.dependencies for entry in self._entries.values()))

    def __iter__(self):
        """Ids of the materials that the engine has."""
        own = [entry.key for entry in self._entries.values() if entry.is_sent]
        return iter((*own, *self._placed))

    def _update(self, block, entry, depsgraph) -> None:
        entry.report = ConversionReport()
        # In the frames of a render only the evaluated one has what is animated.
        evaluated = block.evaluated_get(depsgraph)
        context = material_context(evaluated, entry.report, self._images)
        made = convert_material(
            evaluated,
            entry.key,
            entry.report,
            self.efficacy,
            self._images,
            self._is_patient,
            self.metres,
            context,
        )
        parts = [pictures_of(each) for each in (made, made.seen) if each is not None]
        if any(len({picture.uv_map for picture in part}) > 1 for part in parts):
            context.needs.add(SURFACE)
        entry.needs = all_needs(evaluated, context.needs)
        entry.is_stale, entry.name = False, made.name
        entry.version += 1
        did, entry.displaces = entry.displaces, displaces(block)
        if did or entry.displaces:
            number = block.session_uid
            placed = (key for key, each in self._placed.items() if each.owner == number)
            self._reshaping.update((entry.key, *placed))
        entry.dependencies = shading_dependencies(block)
        entry.is_luminous = _is_luminous(made)
        entry.paints, entry.glow = paints_of(made), colour_of_light(made)
        entry.has_pictures = any(parts)
        digest = content_digest(made)
        if digest != entry.digest:
            entry.digest, entry.waiting = digest, made
            self.remade += 1


def _blocks(depsgraph) -> dict:
    """Materials of Blender by session uid."""
    return {block.session_uid: block for block in members("materials", depsgraph)}


def _tell_crowd(entry: _Entry) -> ConversionReport:
    report = ConversionReport()
    report.warn(
        entry.name,
        f"The material is another one on each of more than {MOST} objects",
        "further ones show it with the mean of what differs",
    )
    return report


def _is_luminous(made: Material) -> bool:
    return made.emission is not None and made.emission.luminance > 0.0
