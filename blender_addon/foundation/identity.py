"""Stable identities of data-blocks: a persistent UUID on each object, light, material, world and camera.

Names change on renaming, pointers on undo and session uids on reopening the file, so none of them is an identity
across time. The UUID is; within a session it is remembered by session uid, so that a copy (which brings its
original's UUID along) is told from its original, and an undo step from before the assignment loses nothing.
"""

import threading
import uuid
from contextlib import contextmanager

import bpy
from bpy.app.handlers import persistent

from ...imports import loaded_when_used
from .handlers import leave, listen

with loaded_when_used():
    import numpy as np

COLLECTIONS = ("objects", "lights", "materials", "worlds", "cameras")
"""Names of the collections of ``bpy.data`` whose members carry an identity."""

_TYPES = {
    bpy.types.Object: "objects",
    bpy.types.Light: "lights",
    bpy.types.Material: "materials",
    bpy.types.World: "worlds",
    bpy.types.Camera: "cameras",
}
_NAMESPACE = uuid.UUID("5d0cb5bb-2a3c-4c6e-8d0b-6f2d7b1f5f11")


class _Memory:
    """Who owns which identity; it belongs to one opened file.

    ``uids``: by session uid, never forgotten, because undo may bring a data-block back. ``owners``: session uid by
    identity. ``unwritten``: session uids of data-blocks that could not be written to. ``copies``: engine ids of copies
    and of their originals, in order.
    """

    def __init__(self):
        self.uids: dict[int, str] = {}
        self.owners: dict[str, int] = {}
        self.unwritten: set[int] = set()
        self.copies: list[tuple[str, str]] = []
        self.is_complete = False


_memory = _Memory()
_here = threading.local()


@contextmanager
def apart():
    """Tell data-blocks apart that are not the file's, such as those of previews, on this thread while it lasts.

    They are copies that Blender makes anew every time: one that carries an identity keeps it, others have it from their
    name. Nothing is remembered or written, and none counts as a copy of the file's.
    """
    _here.is_apart = True
    try:
        yield
    finally:
        _here.is_apart = False


def _is_apart() -> bool:
    return getattr(_here, "is_apart", False)


def members(name: str, depsgraph):
    """Return the data-blocks of a collection of ``bpy.data``; those of the graph where they are not the file's (`apart`)."""
    collection = getattr(bpy.data, name)
    if not _is_apart():
        return collection
    kind = next(cls for cls, of in _TYPES.items() if of == name)
    return [block.original for block in depsgraph.ids if isinstance(block, kind)]


def identity_of(block) -> str:
    """Return the identity of a data-block as 32 hexadecimal digits; the same for its evaluated copies.

    Local data-blocks get one when they are new to us. It is written into the file as soon as Blender allows.
    """
    block = block.original
    if _is_apart():
        words = f"apart\n{block.id_type}\n{block.name}"
        return block.lumenray.uid or uuid.uuid5(_NAMESPACE, words).hex
    if block.library is not None or block.override_library is not None:
        return _derived(block)
    return _memory.uids.get(block.session_uid) or _claim(block)


def engine_id(block) -> str:
    """Return the id of the item that the engine makes of a data-block."""
    if isinstance(block, bpy.types.Object):
        kind = "light" if block.type == "LIGHT" else "object"
    else:
        kind = block.id_type.lower()
    return f"{kind}:{identity_of(block)}"


def copies_since(count: int) -> list[tuple[str, str]]:
    """Return engine ids (copy, original) of the copies found since the first ``count`` ones of this file."""
    return [] if _is_apart() else _memory.copies[count:]


def ensure_ids(updates=None) -> None:
    """Write identities where they are missing; nothing happens on other threads than Blender's main one.

    Parameters
    ----------
    updates : iterable of bpy.types.DepsgraphUpdate or None
        Only what they name is looked at; None: every data-block, which also heals what undo took away.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    if updates is None or _memory.unwritten or not _memory.is_complete:
        _ensure_all()
        return
    known = _memory.uids
    for update in updates:
        block = update.id.original
        if block.session_uid not in known and _is_ours(block):
            _claim(block)


def forget() -> None:
    """Start anew, for another file: its session uids are new, its identities are in the file."""
    global _memory  # noqa: PLW0603 - one file is open at a time
    _memory = _Memory()


def _ensure_all() -> None:
    _memory.unwritten.clear()
    for name in COLLECTIONS:
        blocks = [block for block in getattr(bpy.data, name) if _is_ours(block)]
        alive = {block.session_uid for block in blocks}
        for block in blocks:
            uid, session_uid = identity_of(block), block.session_uid
            owner = _memory.owners[uid]
            if owner != session_uid and owner in alive:
                # An undo brought the dead owner back beside the one that took over.
                original, uid = uid, _remember(session_uid, _new())
                _note_copy(block, original)
            _memory.owners[uid] = session_uid
            if block.lumenray.uid != uid:
                _write(block, uid)
    _memory.is_complete = True


def _is_ours(block) -> bool:
    return (
        isinstance(block, tuple(_TYPES))
        and block.library is None
        and block.override_library is None
    )


def _derived(block) -> str:
    """Identity of a linked data-block or an override: nothing can be written there, but the file's words are stable."""
    if block.library is not None:
        words = (block.id_type, block.library.filepath, block.name)
    else:
        reference = block.override_library.reference
        library = reference.library if reference is not None else None
        words = (
            block.id_type,
            library.filepath if library is not None else "",
            reference.name if reference is not None else "",
            block.name,
        )
    return uuid.uuid5(_NAMESPACE, "\n".join(words)).hex


def _claim(block) -> str:
    """Give a data-block that is not known yet the identity that it carries, or a new one."""
    carried = block.lumenray.uid
    if carried and _is_free(carried, block):
        return _remember(block.session_uid, carried)
    uid = _remember(block.session_uid, _new())
    if carried:
        _note_copy(block, carried)
    _write(block, uid)
    return uid


def _is_free(uid: str, block) -> bool:
    owner = _memory.owners.get(uid)
    if owner is None:
        return True
    kind = next(name for cls, name in _TYPES.items() if isinstance(block, cls))
    others = getattr(bpy.data, kind)
    alive = np.empty(len(others), np.int32)
    others.foreach_get("session_uid", alive)
    return owner not in alive


def _new() -> str:
    return uuid.uuid4().hex


def _remember(session_uid: int, uid: str) -> str:
    _memory.uids[session_uid] = uid
    _memory.owners[uid] = session_uid
    return uid


def _note_copy(block, original: str) -> None:
    if not isinstance(block, bpy.types.Light | bpy.types.Camera):
        new = engine_id(block)
        _memory.copies.append((new, f"{new.partition(':')[0]}:{original}"))


def _write(block, uid: str) -> None:
    """Write an identity into the file, later if Blender does not allow it now (while drawing or rendering)."""
    is_allowed = threading.current_thread() is threading.main_thread()
    if is_allowed:
        try:
            block.lumenray.uid = uid
        except (AttributeError, RuntimeError):
            is_allowed = False
    if not is_allowed:
        _memory.unwritten.add(block.session_uid)


@persistent
def _after_update(_scene, depsgraph):
    ensure_ids(depsgraph.updates)


@persistent
def _after_load(*_):
    forget()
    ensure_ids()


@persistent
def _check_all(*_):
    ensure_ids()


_HANDLERS = {
    "depsgraph_update_post": _after_update,
    "load_post": _after_load,
    "save_pre": _check_all,
    "undo_post": _check_all,
    "redo_post": _check_all,
    "render_init": _check_all,
    "render_pre": _check_all,
}


def attach():
    """Have identities written as data-blocks come."""
    listen(_HANDLERS)


def detach():
    """Stop it; identities stay in the file."""
    leave(_HANDLERS)
    forget()
