"""What a commit did to a compiled scene."""

from dataclasses import dataclass, field


class Outgrown(Exception):  # noqa: N818 - not a fault
    """An edit has moved the frame's origin, or edits have left much waste: everything has to be compiled anew."""


@dataclass(frozen=True)
class Stamps:
    """How often parts of a scene have changed since it was compiled: tells whether what was made of them still holds.

    ``objects``: their shapes and places; ``surfaces``: what they are made of, their own glow included; ``lights``: the world
    included.
    """

    objects: int = 0
    surfaces: int = 0
    lights: int = 0

    def after(self, changes: "Changes") -> "Stamps":
        """Return those after a commit."""
        return Stamps(
            self.objects + int(changes.built + changes.removed > 0),
            self.surfaces + int(changes.surfaces > 0),
            self.lights + int(changes.lights > 0 or bool(changes.other)),
        )


@dataclass
class Changes:
    """What a commit did, counted for people."""

    built: int = 0
    removed: int = 0
    surfaces: int = 0
    lights: int = 0
    is_rebuilt: bool = False
    other: list[str] = field(default_factory=list)

    def text(self) -> str:
        """One line."""
        parts = [
            f"{count} {name}{'s' if count > 1 else ''} {verb}"
            for count, name, verb in (
                (self.built, "object", "built"),
                (self.removed, "object", "removed"),
                (self.surfaces, "surface", "changed"),
                (self.lights, "light", "changed"),
            )
            if count
        ]
        parts += self.other
        if self.is_rebuilt:
            parts.append("search tree rebuilt")
        return ", ".join(parts) or "nothing"
