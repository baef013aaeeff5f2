"""Materials at work: one plug-in for all plain ones (the palette), one of its own for each of the others."""

import mitsuba as mi
import numpy as np

from ...arrays import pointer_id
from ...errors import SceneError
from ...requirements.facts import is_coloured
from ...scene.material import Material
from .bitmaps import key_of
from .surfaces import NOTHING, approximations, bsdf, is_plain, palette, picture_row
from .textures import TextureMaker, is_spectral


class MaterialPalette:
    """Keeps the plug-ins of a scene's materials by id.

    Parameters
    ----------
    light : (471,) array    Mean spectrum of the scene's lights; photometric variants weigh reflectances by it.
    """

    def __init__(self, light: np.ndarray):
        self.make = TextureMaker(light)
        self.palette = mi.load_dict({"type": "lumenray_coated"})
        # Kernels visit every surface model that lives, that of a scene which failed half-way too.
        self.palette.set_palette(**palette([NOTHING], self.make))
        self._palette_number = pointer_id(self.palette)
        self._rows: dict[str, int] = {}
        self._columns: list[dict] = []
        self._plugins: dict[str, tuple[object, int]] = {}
        self._items: dict[str, Material] = {}
        self._pictures: dict[str, frozenset[tuple]] = {}
        self._has_unused = False
        self._changed = True

    def set_light(self, light: np.ndarray) -> None:
        """Weigh reflectances by another light."""
        self.make = TextureMaker(light, self.make.bitmaps)
        if not is_spectral():
            renewed: set[int] = set()
            for item in [item for item in self._items.values() if is_coloured(item.surface)]:
                if id(item.surface) not in renewed or item.id in self._rows:
                    self._put(item, [item.id, *self._sharers(item)])
                    renewed.add(id(item.surface))

    def put(self, material: Material) -> None:
        """Take a material in, new or changed. Those of the very same surface share a plug-in."""
        sharers = [] if is_plain(material.surface) else self._sharers(material)
        if not sharers:
            self._put(material, [material.id])
            return
        if material.id in self._rows:
            self._give_row_back(material.id)
        self._items[material.id] = material
        self._plugins[material.id] = self._plugins[sharers[0]]
        self._note_pictures(material, self._pictures.get(sharers[0], frozenset()))

    def _sharers(self, material: Material) -> list[str]:
        """Ids of other materials with a plug-in for the very same surface."""
        return [
            key
            for key, item in self._items.items()
            if item.surface is material.surface and key != material.id and key in self._plugins
        ]

    def _put(self, material: Material, alike: list[str]) -> None:
        """Take a material in, and its plug-in for it and all that are alike."""
        was_plain = material.id in self._rows
        self._items[material.id] = material
        if is_plain(material.surface):
            if not was_plain:
                self._rows[material.id] = self._free_row()
            self._columns[self._rows[material.id]] = self._columns_of(material)
            self._changed = True
            self._plugins.pop(material.id, None)
            return
        if was_plain:
            self._give_row_back(material.id)
        self.make.bitmaps.asked.clear()
        try:
            model = bsdf(material.surface, self.make)
        except SceneError as error:
            raise SceneError(f"material '{material.name}': {error}") from error
        # Textures that happen to be equal must stay apart, as they would make another model to a kernel.
        is_made = not isinstance(model, dict)
        plugin = model if is_made else mi.load_dict(model, optimize=False)
        self._note_pictures(material, frozenset(self.make.bitmaps.asked))
        old = self._plugins.get(material.id)
        users = [
            key for key, kept in self._plugins.items() if old is not None and kept[0] is old[0]
        ]
        # Others that share the old one must not change.
        if old is None or not set(users) <= set(alike) or not _transplant(plugin, old[0]):
            self._plugins |= dict.fromkeys(alike, (plugin, pointer_id(plugin)))

    def drop(self, material_id: str) -> None:
        """Forget a material that no shape uses any more."""
        self._items.pop(material_id, None)
        if material_id in self._rows:
            self._give_row_back(material_id)
        self._plugins.pop(material_id, None)
        self._has_unused |= bool(self._pictures.pop(material_id, None))

    def item(self, material_id: str) -> Material | None:
        """Return a material as it was taken in."""
        return self._items.get(material_id)

    def plugin_number(self, material_id: str) -> int:
        """Return the number by which kernels know the plug-in of a material."""
        plugin = self._plugins.get(material_id)
        return self._palette_number if plugin is None else plugin[1]

    def row(self, material_id: str) -> int:
        """Return the row of a plain material, 0 for others."""
        return self._rows.get(material_id, 0)

    def notes(self) -> list[str]:
        """Say what is computed otherwise than stated."""
        return [
            f"material '{self._items[key].name}': {text}"
            for key in self._plugins
            for text in approximations(self._items[key].surface)
        ]

    def commit(
        self,
        rows_by_shape: np.ndarray,
        frames: np.ndarray | None = None,
        ways: np.ndarray | None = None,
        coordinates: np.ndarray | None = None,
    ) -> None:
        """Bring the palette up to date.

        Parameters
        ----------
        rows_by_shape : (n,) array    Row of the shape with each number.
        frames : (n, 3, 3) array or None    Axes of the objects of the shapes, where something has a relief.
        ways : (n, 3, 4, 3) array or None    As `grain_ways` finds them, where facets lie round an axis.
        coordinates : (n, 4, 3) array or None    As `find_coordinates` finds them, where flakes are seen.
        """
        if self._has_unused:
            self.make.bitmaps.keep(set().union(*self._pictures.values()))
            self._has_unused = False
        self.make.bitmaps.table.commit()
        if self._changed:
            columns = self._columns or [palette([NOTHING], self.make)]
            self.palette.set_palette(
                **{name: np.concatenate([c[name] for c in columns]) for name in columns[0]},
                picture_table=self.make.bitmaps.table,
            )
            self._changed = False
        self.palette.set_rows(rows_by_shape)
        for plugin, _ in self._plugins.values():
            if frames is not None:
                _give(plugin, "set_frames", frames)
            if ways is not None:
                _give(plugin, "set_ways", ways)
            if coordinates is not None:
                _give(plugin, "set_coordinates", coordinates)

    def _columns_of(self, material: Material) -> dict[str, np.ndarray]:
        """Row of a plain material, and note the picture that it shows."""
        self.make.bitmaps.asked.clear()
        columns = palette([material.surface], self.make)
        columns["pictures"] = np.array([picture_row(material.surface, self.make)])
        self._note_pictures(material, frozenset(self.make.bitmaps.asked))
        return columns

    def _note_pictures(self, material: Material, keys: frozenset[tuple]) -> None:
        """Note which textures a material uses, that of its emission included."""
        glow = material.emission
        if glow is not None and glow.pattern is not None:
            keys = keys | {key_of(glow.pattern)}
        old = self._pictures.get(material.id, frozenset())
        self._has_unused |= bool(old - keys)
        if keys:
            self._pictures[material.id] = keys
        else:
            self._pictures.pop(material.id, None)

    def _give_row_back(self, material_id: str) -> None:
        """Let others use the row of a material, which shows no picture any more."""
        columns = self._columns[self._rows.pop(material_id)]
        self._changed |= bool(columns["pictures"].any())
        columns["pictures"] = np.zeros(1)

    def _free_row(self) -> int:
        taken = set(self._rows.values())
        for row in range(len(self._columns)):
            if row not in taken:
                return row
        self._columns.append({})
        return len(self._columns) - 1


def _give(plugin, method: str, table: np.ndarray) -> None:
    """Give all parts of a surface model that ask for it what is known of the objects by their shapes."""
    if hasattr(plugin, method):
        getattr(plugin, method)(table)
    for name in ("first", "second", "base", "nested"):
        if hasattr(plugin, name):
            _give(getattr(plugin, name), method, table)


def _transplant(new, old) -> bool:
    """Give a plug-in the values of another of the same build, so that kernels do not change; false if it is none."""
    if type(new) is not type(old):
        return False
    if hasattr(new, "__dict__") and new.__dict__:
        if any(type(new.__dict__.get(k)) is not type(v) for k, v in old.__dict__.items()):
            return False
        old.__dict__.update(new.__dict__)
        if isinstance(new, mi.BSDF):
            # What a surface can do may depend on its data, and these two are not in Python's dictionary.
            old.m_components, old.m_flags = new.m_components, new.m_flags
        return True
    values, given = mi.traverse(old), mi.traverse(new)
    if (
        list(values.keys()) != list(given.keys())
        or str(old).split("[")[0] != str(new).split("[")[0]
    ):
        return False
    changed = []
    for key in given.keys():  # noqa: SIM118 - not a dictionary
        if type(values[key]) is not type(given[key]):
            return False
        if _owner(values, key) is not _owner(given, key):
            if key.endswith(".to_uv"):
                # Other materials may use the same texture, and what else it has does not show here.
                return False
            changed.append(key)
    for key in changed:
        values[key] = given[key]
    values.update()
    return True


def _owner(values, key: str):
    """Return the object that a parameter belongs to."""
    return values.properties[key][2]
