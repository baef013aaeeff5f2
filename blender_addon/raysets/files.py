"""Ray files behind lights. Rays of a large file take half a minute to prepare."""

import bpy

from ...imports import loaded_when_used
from ...libraries.raysets import FOLDER, PREFIX
from ..file_assets.kind import FileKind
from ..file_assets.places import Library

with loaded_when_used():
    from ...engine.raysets import cloud, emission, index, record, text

KEPT = 16
"""Prepared files that are kept, of 10 MB each at most."""

SYMMETRY = {"AUTO": None, "ON": True, "OFF": False}


class RayFiles(FileKind):
    """Files that lights shine as; their reading is a `RayLight`."""

    noun = "ray file"
    library = Library(PREFIX, FOLDER, ".tm25ray")
    under_way = "its rays are being prepared ({share:.0f} %)"
    stopped = "its rays were not prepared: stopped"
    fault = "its rays cannot be prepared ({cause})"
    is_stopped_unwanted = True

    def __init__(self, kept: int, thread: str = ""):
        super().__init__(kept, thread)
        # Paths whose rays are prepared even if they were kept.
        self._fresh: set[str] = set()

    def terms_of(self, settings) -> "emission.Wish":
        position = direction = None
        if settings.use_widths:
            position, direction = 1e-3 * settings.width_position, settings.width_direction
        fluctuation = cloud.Fluctuation(None, position, direction, SYMMETRY[settings.symmetry])
        quantity = record.LUMINOUS if settings.is_luminous else record.RADIANT
        return emission.Wish(fluctuation, text.Assumed(settings.unit, quantity))

    def source(self, settings) -> tuple:
        key, _ = super().source(settings)
        path, wish, is_kept = key[0], key[-1], settings.keep_index
        # Where there is no file, that is told at once.
        index.state_of(path, wish)

        def prepare():
            is_fresh = path in self._fresh
            self._fresh.discard(path)
            return lambda job: index.obtain_light(
                path, wish, is_kept, is_fresh, job.tell, job.stop.is_set
            )

        return key, prepare

    def users(self):
        return (light for light in bpy.data.lights if light.lumenray.rayset.use_file)

    def forget(self, settings=None) -> None:
        # Before: a render may ask for it at any time.
        if settings is not None:
            self._fresh.add(self.absolute_path(settings))
        super().forget(settings)

    def keep(self, settings) -> None:
        """Write what is known of the file of settings beside it; nothing happens to one that is not ready.

        Raises
        ------
        FileFormatError    It cannot be written.
        """
        key, _ = super().source(settings)
        light = self._shelf.ready(key)
        if light is not None:
            index.save_light(key[0], light, key[-1])


ray_files = RayFiles(KEPT, "lumenray-rays")
