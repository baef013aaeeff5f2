"""The pictures that the engine has: each is sent once, however many materials show it."""

from ....engine.scene.scene import LARGE, array_digest
from ....engine.scene.texture import Pixels, replace_pixels


class PictureTable:
    """Pixels by id, and which materials and worlds use them."""

    def __init__(self):
        self._sent: set[str] = set()
        self._new: dict[str, Pixels] = {}
        self._users: dict[str, frozenset[str]] = {}

    def __iter__(self):
        """Ids of the pixels that the engine has."""
        return iter(self._sent)

    def put(self, item):
        """Return a material or world as it is sent: with the ids of its larger pictures in place of their pixels."""
        used: set[str] = set()

        def name(pixels):
            if pixels.nbytes < LARGE:
                return pixels
            key = f"pixels:{array_digest(pixels).hex()}"
            used.add(key)
            if key not in self._sent and key not in self._new:
                self._new[key] = Pixels(key, pixels)
            return key

        made = replace_pixels(item, name)
        self._users[item.id] = frozenset(used)
        return made

    def drop(self, owner: str) -> None:
        """Note that a material or world is gone, by its id."""
        self._users.pop(owner, None)

    def flush(self) -> tuple[list[Pixels], list[str]]:
        """Hand over what the engine lacks and the ids of what nothing uses any more."""
        used = frozenset().union(*self._users.values())
        made = [pixels for key, pixels in self._new.items() if key in used]
        gone = sorted(self._sent - used)
        self._sent, self._new = set(used), {}
        return made, gone
