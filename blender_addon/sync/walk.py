"""One walk over the instances of a dependency graph: what changed since the one before."""

from dataclasses import replace

import bpy
import numpy as np

from ...engine.errors import LumenrayError, SceneError
from ...engine.scene.checks import check_reach
from ...engine.scene.light import Light
from ...engine.scene.mesh import Placement
from ...engine.scene.modelling import Modelling
from ...engine.scene.scene import content_digest
from ..daylight.following import lamp_of
from ..daylight.moment import frame_of
from ..foundation import identity
from ..foundation.report import ConversionReport
from ..foundation.units import metres_per_unit
from ..luminaires.convert import find_housing
from ..luminaires.settings import is_luminaire, settings_of
from ..modelling.wishes import read_wishes
from ..raysets.settings import is_rayset
from ..sun_direction import towards_lamp
from .coloured_light import colour_of_light, tell_coloured_light
from .departures import OBJECT, SCENE, SHUTTER, STILL, WORLD, tell, tell_passes
from .displacement import Displacement, displaces, follows_object
from .grounds import camera_state, follows_camera, photos_of, plane_of, project_world
from .hair import hair_systems, read_curves, read_hair, read_points
from .instance_attributes import InstanceAttributes
from .lights.lights import convert_light
from .lights.portals import GEOMETRY, is_portal, portal_frame, portal_geometry
from .nodes.dependencies import shading_dependencies
from .nodes.needs import ATTRIBUTE, FRAME, PLACE, SURFACE
from .nodes.placed import Subject
from .placing import Place, place_key, read_values, wants_surface
from .sent import Sent, SentWorld, Shown
from .skies import SkyTime, tell_sun
from .tags import Tags
from .visibility import (
    NO_ID,
    collection_flags,
    find_unrendered,
    is_blurred,
    is_catcher,
    is_dark_world,
    is_holdout,
    is_rendered,
    tell_departures,
    tell_linking,
    tell_visibility,
    visibility_of,
)
from .world import convert_world, follows_sun_lamp, follows_time, world_of

NO_LIGHT = "the scene has no light"
"""Message of the row about that."""

UNSUPPORTED = {"VOLUME", "GREASEPENCIL", "GPENCIL"}
"""Object types that are reported and left out. Text, curves, surfaces and metaballs also come as meshes."""

STRANDS = {"CURVES", "POINTCLOUD"}
"""Object types of which triangles are made."""


HAIR = "hair"
"""What the strands of an object's particles are called beside itself."""


class Walk:
    """One pass over the instances."""

    def __init__(
        self, sent: Sent, final: bool, depsgraph, visible, tags: Tags, is_moment: bool = False
    ):
        self.sent, self.final, self.is_moment = sent, final, is_moment
        self.depsgraph, self.visible, self.tags = depsgraph, visible, tags
        self.scene, self.layer = depsgraph.scene, depsgraph.view_layer
        self.changed: list[Placement | Light] = []
        self.worlds: list = []
        self.wishes: list[Modelling] = []
        self.world_changed = self.wishes_changed = False
        self.removed: list[str] = []
        self.visited = 0
        self.counts = {"added": 0, "moved": 0, "changed": 0, "removed": 0}
        self.number = sent.walks = sent.walks + 1
        self._own_data: dict[int, int] = {}
        self._ordinals: dict[int, dict[int, int]] = {}
        self._attributes = InstanceAttributes()

    def run(self) -> None:
        """Visit everything that the tags call for."""
        sent, tags = self.sent, self.tags
        scale, efficacy = metres_per_unit(self.scene), self.scene.lumenray.efficacy
        self.is_rescaled = scale != sent.scale
        self.is_rerated = efficacy != sent.efficacy
        override = self.layer.material_override
        filters = (self.layer.use_solid, override.session_uid if override else 0)
        filters += (collection_flags(self.layer),)
        self.is_refiltered = filters != sent.filters
        sent.filters = filters
        sent.scale, sent.efficacy, sent.materials.efficacy = scale, efficacy, efficacy
        sent.materials.metres = scale
        sent.geometries.mark(tags.geometry)
        sent.images.forget(tags.shading)
        sent.materials.mark(tags.shading)
        if self.is_rerated or self.is_rescaled:
            sent.materials.mark_all()
        # Before the objects: materials displace meshes, and what they need of objects decides what there is of them.
        self.is_replaced = sent.materials.renew(self._used_materials(), self.depsgraph)
        self._reshaping = sent.materials.take_reshaping()
        if self._concerns_objects() or self.is_replaced:
            self._visit_all()
            self._sweep()
            sent.geometries.lay_out(self._charts())
        sent.materials.refresh(self._used_materials(), self.depsgraph)
        self._update_world()
        self._update_wishes()

    def images(self) -> set[int]:
        """Return session uids of the images, among others, that what is shown reads."""
        sent = self.sent
        lights = (shown.shading for shown in sent.shown.values() if shown.shading)
        return sent.materials.dependencies() | sent.world.shading.union(*lights)

    def report(self, is_blurred: bool = False) -> ConversionReport:
        """Return the rows of everything that is shown. ``is_blurred``: as of `SceneSync`."""
        sent, whole = self.sent, ConversionReport()
        reports, is_lit = sent.materials.tell(self._used_materials())
        for shown in sent.shown.values():
            is_lit |= not shown.is_dark and shown.item is not None and bool(shown.digest)
            if shown.report is not None and shown.walk == sent.last_visit:
                reports.append(shown.report)
        if sent.world.report is not None:
            reports.append(sent.world.report)
        for part in reports:
            whole.include(part)
        tell(SCENE, self.scene, self.scene.name, whole)
        tell(SHUTTER if is_blurred else STILL, self.scene, self.scene.name, whole)
        tell_passes(self.layer, whole)
        self._tell_colours(whole)
        self._tell_sun(whole)
        if not is_lit and not sent.world.gives_light:
            whole.warn(self.scene.name, NO_LIGHT, "everything is black")
        return whole

    def _tell_sun(self, whole: ConversionReport) -> None:
        """Note what is wrong with the Sun light that follows the world's place and time."""
        world = self.scene.world
        lamp = None if world is None else lamp_of(self.scene, world)
        if lamp is None:
            return
        for shown in self.sent.shown.values():
            is_seen = shown.walk == self.sent.last_visit
            if shown.source == lamp.session_uid and is_seen and shown.towards_sun is not None:
                when = SkyTime(self.scene, frame_of(self.scene))
                tell_sun(world.evaluated_get(self.depsgraph), when, shown.towards_sun, whole)

    def _tell_colours(self, whole: ConversionReport) -> None:
        """Note what spectra change of coloured light on coloured surfaces."""
        sent = self.sent
        lights, paints = sent.materials.colours(self._used_materials())
        for shown in sent.shown.values():
            if shown.digest and not shown.is_dark:
                lights.append((shown.name, colour_of_light(shown.item)))
        if sent.world.gives_light:
            lights.append(("the world", sent.world.colour))
        lights += [(sun.name, colour_of_light(sun)) for sun in sent.world.suns]
        coloured = [(name, colour) for name, colour in lights if colour is not None]
        has_white = len(coloured) < len(lights)
        tell_coloured_light(coloured, paints, has_white, self.scene.name, whole)

    # ---- objects ----

    def _concerns_objects(self) -> bool:
        tags = self.tags
        return bool(
            self.is_refiltered
            or tags.objects
            or tags.geometry
            or tags.scene
            or self._reshaping
            or any(not s.shading.isdisjoint(tags.shading) for s in self.sent.shown.values())
        )

    def _visit_all(self) -> None:
        sent, tags = self.sent, self.tags
        sent.last_visit = self.number
        touched = tags.objects | tags.geometry | tags.shading
        is_all = self.is_rescaled or self.is_rerated or self.is_refiltered or self.is_replaced
        shown_before, number, shows_hair = sent.shown, self.number, self.layer.use_strand
        matrices = _read_matrices(self.depsgraph.object_instances)
        if self.final:
            self._unrendered = find_unrendered(self.layer)
        for row, instance in enumerate(self.depsgraph.object_instances):
            has_hair = shows_hair and instance.show_particles
            if not (instance.show_self or has_hair) or not self._is_visible(instance):
                continue
            source = instance.object
            has_hair = has_hair and source.type == "MESH" and bool(hair_systems(source))
            original = source.original
            session_uid = original.session_uid
            if instance.is_instance:
                parent = instance.parent
                owner = parent.original.session_uid if parent is not None else 0
                key = (owner, tuple(instance.persistent_id), session_uid)
                is_touched = is_all or session_uid in touched or owner in touched
            else:
                key = session_uid
                is_touched = is_all or session_uid in touched
            self.visited += 1
            matrix = matrices[64 * row : 64 * row + 64]
            for part in (HAIR,) * has_hair + ("",) * instance.show_self:
                shown = shown_before.get((key, part) if part else key)
                is_new = shown is None
                if is_new:
                    shown = Shown(session_uid, key == session_uid)
                    shown_before[(key, part) if part else key] = shown
                shown.walk = number
                if self.is_moment and shown.matrix and not is_blurred(source, instance):
                    continue
                if (
                    is_touched
                    or is_new
                    or shown.is_dark
                    or shown.data in touched
                    or (shown.shading and not shown.shading.isdisjoint(touched))
                    or self._is_reshaped(shown)
                    or (shown.follows_scene and tags.scene)
                ):
                    self._convert_part(part, shown, instance, source, original)
                elif matrix != shown.matrix and (shown.item is not None or shown.is_far):
                    self._move(part, shown, instance, source, original)
                shown.matrix = matrix

    def _is_reshaped(self, shown) -> bool:
        """Whether a material that displaces an object has changed."""
        if not self._reshaping or not isinstance(shown.item, Placement):
            return False
        return not self._reshaping.isdisjoint(shown.item.materials)

    def _is_visible(self, instance) -> bool:
        if self.final and not is_rendered(instance, self._unrendered):
            return False
        return self.visible is None or self.visible(instance)

    def _move(self, part, shown, instance, source, original) -> None:
        is_plain = isinstance(shown.item, Placement) and not shown.is_placed
        if is_plain and not shown.is_anchored and shown.item.geometry != GEOMETRY:
            self._place(shown, replace(shown.item, frame=self._frame(instance)))
        else:
            self._convert_part(part, shown, instance, source, original)

    def _convert_part(self, part, shown, instance, source, original) -> None:
        convert = self._convert_hair if part else self._convert
        convert(shown, instance, source, original)

    def _frame(self, instance) -> np.ndarray:
        frame = np.array(instance.matrix_world, dtype=np.float64)
        frame[:3] *= self.sent.scale
        return frame

    def _convert(self, shown, instance, source, original) -> None:
        """Convert an instance that is new or touched."""
        data = original.data
        shown.data = data.session_uid if data is not None else 0
        shown.report = shown.towards_sun = None
        shown.is_anchored = False
        kind = source.type
        if kind == "EMPTY" and is_luminaire(source):
            kind = "LIGHT"
        if kind not in {"MESH", "LIGHT"} | STRANDS and kind not in UNSUPPORTED:
            self._place(shown, None)
            return
        if kind == "MESH" and original.lumenray.is_luminaire_body:
            self._convert_housing(shown, instance, source, original)
            return
        if original.type == "LIGHT" and is_portal(original.data) and not _is_special(source):
            kind = "PORTAL"
        self._name(shown, instance, original, kind)
        if kind == "MESH":
            slots, geometry = self._slots(source), None
            shown.is_anchored = not all(map(follows_object, slots))
            if self.layer.use_solid:
                geometry = self._geometry(shown, instance, source, original, slots)
            self._convert_surface(shown, instance, source, original, geometry)
        elif kind in STRANDS:
            shown.is_mapped = False
            read = read_points if kind == "POINTCLOUD" else self._read_curves
            geometry = None
            if kind == "POINTCLOUD" or self.layer.use_strand:
                geometry = self._geometry(shown, instance, source, original, read=read)
            self._convert_surface(shown, instance, source, original, geometry)
        elif kind == "PORTAL":
            self._convert_portal(shown, instance, source)
        elif kind == "LIGHT":
            self._convert_light(shown, instance, source, original)
        else:
            shown.report = ConversionReport()
            note = shown.report.medium if kind == "VOLUME" else shown.report.error
            note(shown.name, f"objects of type {kind} are not converted", "left out")
            self._place(shown, None)

    def _convert_hair(self, shown, instance, source, original) -> None:
        """Convert the strands of an object's particles."""
        shown.is_mapped, shown.data = False, original.data.session_uid
        self._name(shown, instance, original, "MESH", HAIR)
        geometry = self._kept_geometry(shown, instance, source)
        if geometry is None:
            key = f"geometry:{identity.identity_of(original)}/{HAIR}"
            is_render = self.depsgraph.mode == "RENDER"
            geometry = self.sent.geometries.take(
                key,
                original.session_uid,
                source,
                lambda item, name: read_hair(item, name, is_render),
            )
        self._convert_surface(shown, instance, source, original, geometry)

    def _read_curves(self, source, geometry_id):
        settings = getattr(self.scene, "cycles_curves", None)
        is_smooth = settings is None or settings.shape != "THICK_LINEAR"
        return read_curves(source, geometry_id, is_smooth)

    def _name(self, shown, instance, original, kind, part: str = "") -> None:
        shown.name, key = original.name_full, identity.identity_of(original)
        if not shown.is_own:
            parent = instance.parent
            numbers = [number for number in instance.persistent_id if number != NO_ID]
            if parent is not None and parent.original == original and original.type != "MESH":
                # What text, curves, surfaces and metaballs evaluate to comes as an instance of their own.
                shown.is_own = numbers == [0]
            if not shown.is_own:
                number = ".".join(map(str, numbers))
                owner = identity.identity_of(parent) if parent is not None else ""
                owner_name = parent.name_full if parent is not None else ""
                shown.name = f"{shown.name} ({owner_name} {number})"
                key = f"{owner}/{number}/{key}"
        is_light = kind == "LIGHT" and original.type == "LIGHT"
        key = f"{'light' if is_light else 'object'}:{key}"
        if part:
            shown.name, key = f"{shown.name} ({part})", f"{key}/{part}"
        if shown.key and shown.key != key:
            self._place(shown, None)
        shown.key = key

    def _convert_surface(self, shown, instance, source, original, geometry: str | None) -> None:
        """Convert something that has a surface. ``geometry``: its id, None if it has no face."""
        layer = self.layer
        slots = self._slots(source)
        if geometry is None:
            self._place(shown, None)
            return
        table = self.sent.materials
        materials = tuple(table.use(material, self.depsgraph) for material in slots)
        parent = instance.parent if instance.is_instance and not shown.is_own else None
        placed = self._place_materials(shown, instance, source, geometry, slots)
        found = visibility_of(source, parent, layer)
        report = ConversionReport()
        tell_visibility(found, shown.name, report)
        tell_departures(source, shown.name, report, layer, parent)
        tell(OBJECT, original, shown.name, report)
        if found.light and table.is_luminous(slots):
            tell_linking(source, shown.name, report)
        if not shown.is_mapped and table.has_pictures(slots):
            report.error(
                shown.name,
                "the material varies over the surface, and strands and points have no UV maps here",
                "its pictures are laid over each triangle",
            )
        if note := self.sent.geometries.note(geometry):
            report.warn(shown.name, note, "blocks of the picture are right on the mean alone")
        displaced = self.sent.geometries.report(geometry)
        if displaced is not None:
            report.include(displaced)
        shown.report = report if report.rows else None
        placement = Placement(
            id=shown.key,
            name=shown.name,
            geometry=geometry,
            frame=self._frame(instance),
            materials=placed or materials,
            visible_to_camera=found.camera,
            index=source.pass_index,
            meets_light=found.light,
            is_holdout=is_holdout(source, parent, layer),
            is_catcher=is_catcher(source, parent),
        )
        self._place(shown, placement)

    def _place_materials(self, shown, instance, source, geometry, slots) -> tuple[str, ...]:
        """Return the ids of an object's materials where some of them are made for it, () if none is."""
        table, geometries = self.sent.materials, self.sent.geometries
        asked = [table.needs(material) for material in slots]
        parent = instance.parent if instance.is_instance and not shown.is_own else None
        charts, keys, followed, is_placed = set(), [], set(), False
        displacement = self._displacement(instance, slots)
        for slot, (material, needed) in enumerate(zip(slots, asked, strict=True)):
            keys.append(table.use(material, self.depsgraph))
            has_surface = shown.is_mapped and wants_surface(needed, geometries.uv_bounds(geometry))
            values = read_values(needed, instance, source, parent, self.depsgraph, self._attributes)
            if not has_surface and not values and PLACE not in needed:
                continue
            is_placed = True
            part = (slot, slot == len(slots) - 1)
            place = Place(
                place_key(
                    keys[-1], needed, shown.key, geometry if has_surface else "", slot, values
                ),
                Subject(_matrix_for(instance, needed), values),
                geometries.surface(geometry, source, displacement) if has_surface else None,
                *part,
                is_optional=SURFACE not in needed,
            )
            keys[-1] = table.place(material, place)
            if has_surface:
                charts.add(part)
            followed |= needed
        shown.charts, shown.is_placed = frozenset(charts), is_placed
        shown.shading = frozenset(need[1] for need in followed if need[0] == FRAME)
        shown.follows_scene = any(need[:2] == (ATTRIBUTE, "VIEW_LAYER") for need in followed)
        return tuple(keys) if is_placed else ()

    def _charts(self) -> dict[str, set]:
        """Slots whose materials are made for a surface, by the geometries that are shown."""
        found: dict[str, set] = {}
        for shown in self.sent.shown.values():
            if isinstance(shown.item, Placement):
                found.setdefault(shown.item.geometry, set()).update(shown.charts)
        return found

    def _convert_housing(self, shown, instance, source, original) -> None:
        """Convert the body of a luminaire, which is only looked at unless its housing is to block light."""
        lamp = instance.parent if instance.is_instance else None
        settings = settings_of(lamp)
        if (
            settings is None
            or not settings.use_file
            or not getattr(settings, "blocks_light", False)
        ):
            self._place(shown, None)
            return
        self._name(shown, instance, original, "MESH")
        shown.is_anchored, shown.report = True, ConversionReport()
        try:
            geometry, frame = find_housing(lamp, settings, self.sent.scale)
        except LumenrayError as error:
            shown.report.warn(lamp.name_full, f"its housing blocks no light: {error}", "left out")
            self._place(shown, None)
            return
        shown.shading, shown.charts = frozenset(), frozenset()
        found = visibility_of(source, lamp, self.layer)
        material = self.sent.materials.use(self._slots(source)[0], self.depsgraph)
        placement = Placement(
            id=shown.key,
            name=shown.name,
            geometry=self.sent.geometries.take_made(geometry),
            frame=frame,
            materials=(material,),
            visible_to_camera=found.camera,
            index=source.pass_index,
            meets_light=found.light,
        )
        self._place(shown, placement)

    def _convert_portal(self, shown, instance, source) -> None:
        shown.shading = frozenset()
        frame = portal_frame(source.data, instance.matrix_world, self.sent.scale)
        geometry = self.sent.geometries.take_made(portal_geometry())
        material = self.sent.materials.use_portal()
        self._place(shown, Placement(shown.key, shown.name, geometry, frame, (material,), False, 0))

    def _kept_geometry(self, shown, instance, source) -> str | None:
        """Id of the geometry that an instance keeps while the shutter is open, None if it is to be read."""
        is_kept = self.is_moment and isinstance(shown.item, Placement)
        if is_kept and not is_blurred(source, instance, "use_deform_motion"):
            return shown.item.geometry
        return None

    def _slots(self, source) -> list:
        """Materials of an object, None where it has none."""
        override = self.layer.material_override
        return [override or slot.material for slot in source.material_slots] or [override]

    def _geometry(self, shown, instance, source, original, slots=(), read=None) -> str | None:
        """Id of the geometry that an instance shows; objects that show the same data share it, but for displaced ones.

        ``slots``: materials that may displace it; ``read``: as of `GeometryTable.take`.
        """
        kept = self._kept_geometry(shown, instance, source)
        if kept is not None:
            return kept
        take, owner = self.sent.geometries.take, original.session_uid
        displacement = self._displacement(instance, slots)
        if displacement is not None:
            take = self._displaced(displacement, instance, slots)
        if original.type != "MESH" or (
            instance.is_instance and source.data.as_pointer() != self._data_of(original)
        ):
            # Made by geometry nodes, or what a curve evaluates to: told apart by their order.
            known = self._ordinals.setdefault(owner, {})
            ordinal = known.setdefault(source.data.as_pointer(), len(known))
            key = f"geometry:{identity.identity_of(original)}/{ordinal}"
            return take(key, owner, source, read)
        settings = "RENDER" if self.depsgraph.mode == "RENDER" else "PREVIEW"
        if original.is_modified(self.scene.original, settings):
            return take(f"geometry:{identity.identity_of(original)}", owner, source)
        owner = original.data.session_uid
        return take(f"geometry:data/{owner}", owner, source)

    def _displacement(self, instance, slots) -> Displacement | None:
        """What moves the vertices of an object; None: no material of its slots does."""
        moving = tuple(each if displaces(each) else None for each in slots)
        if not any(moving):
            return None
        frame = np.array(instance.matrix_world, dtype=np.float64)
        return Displacement(moving, frame, self.sent.images)

    def _displaced(self, displacement: Displacement, instance, slots):
        """What takes the geometry of an object whose materials displace it."""
        table, is_movable = self.sent.materials, all(map(follows_object, slots))
        known = [table.use(each, self.depsgraph) and table.version(each) for each in slots if each]
        place = b"" if is_movable else displacement.frame.tobytes()
        moving = displacement.materials
        cause = (tuple(each and each.original.session_uid for each in moving), *known, place)
        name = f"{instance.object.original.session_uid}/{tuple(instance.persistent_id)}"

        def take(key, owner, source, read=None):
            own = f"{key}/displaced" if is_movable else f"{key}/displaced/{name}"
            own = f"{own}/{'.'.join(str(number) for number in cause[0])}"
            return self.sent.geometries.take(own, owner, source, read, displacement, cause)

        return take

    def _data_of(self, original) -> int:
        """Address of the data that an object itself shows, within this walk."""
        session_uid = original.session_uid
        if session_uid not in self._own_data:
            data = original.evaluated_get(self.depsgraph).data
            self._own_data[session_uid] = data.as_pointer()
        return self._own_data[session_uid]

    def _place(self, shown, placement: Placement | None) -> None:
        """Send a placement if it differs from what was sent; None takes away what was."""
        before = shown.item
        shown.is_far = placement is not None and self._is_far(shown, placement)
        if shown.is_far:
            placement = None
        shown.item, shown.digest, shown.is_dark = placement, b"", False
        if placement is None:
            if before is not None:
                self.removed.append(before.id)
            return
        if not isinstance(before, Placement):
            self.counts["added"] += 1
        else:
            is_same = (
                before.geometry == placement.geometry
                and before.materials == placement.materials
                and before.visible_to_camera == placement.visible_to_camera
                and before.meets_light == placement.meets_light
                and before.is_holdout == placement.is_holdout
                and before.is_catcher == placement.is_catcher
                and before.index == placement.index
            )
            if not np.array_equal(before.frame, placement.frame):
                self.counts["moved"] += 1
            elif is_same:
                return
            else:
                self.counts["changed"] += 1
        self.changed.append(placement)

    def _is_far(self, shown, placement: Placement) -> bool:
        """Tell whether an object lies too far away to be computed beside others, or nowhere, and note it."""
        corners = self.sent.geometries.corners(placement.geometry)
        with np.errstate(over="ignore", invalid="ignore"):
            corners = corners @ placement.frame[:3, :3].T + placement.frame[:3, 3]
        try:
            check_reach("it", corners.min(axis=0), corners.max(axis=0))
        except SceneError as error:
            shown.report = shown.report or ConversionReport()
            shown.report.error(shown.name, str(error), "the object is left out")
            return True
        return False

    def _convert_light(self, shown, instance, source, original) -> None:
        sent, shown.report = self.sent, ConversionReport()
        shown.shading = (
            shading_dependencies(original.data) if original.type == "LIGHT" else frozenset()
        )
        if shown.is_own and original.type == "LIGHT" and original.data.type == "SUN":
            shown.towards_sun = towards_lamp(instance.matrix_world)
        light = convert_light(
            source,
            shown.key,
            shown.name,
            instance.matrix_world,
            sent.scale,
            sent.efficacy,
            shown.report,
            sent.images,
            self.final,
        )
        if light is None:
            self._darken(shown)
            return
        shown.is_dark, digest = False, content_digest(light)
        if digest != shown.digest:
            shown.item, shown.digest = light, digest
            self.changed.append(light)

    def _darken(self, shown) -> None:
        """Make a light that the engine has emit nothing: cheaper than taking it away, and it may come back."""
        if not shown.is_dark and shown.item is not None:
            light = shown.item
            shown.item = replace(light, output=replace(light.output, value=0.0))
            shown.digest = content_digest(shown.item)
            self.changed.append(shown.item)
        shown.is_dark = True

    # ---- what is no longer there ----

    def _sweep(self) -> None:
        sent, number = self.sent, self.number
        missing = [key for key, shown in sent.shown.items() if shown.walk != number]
        alive = {b.session_uid for b in bpy.data.objects if b.users} if missing else set()
        for key in missing:
            shown = sent.shown[key]
            is_light = shown.item is not None and bool(shown.digest)
            if is_light and shown.is_own and shown.source in alive:
                self._darken(shown)
                continue
            del sent.shown[key]
            if shown.item is not None:
                self.removed.append(shown.item.id)
                self.counts["removed"] += isinstance(shown.item, Placement)
        places = [s for s in sent.shown.values() if isinstance(s.item, Placement)]
        used = {shown.item.geometry for shown in places}
        sent.geometries.sweep(used, {shown.source for shown in places})

    def _used_materials(self) -> set[str]:
        return {
            material
            for shown in self.sent.shown.values()
            if isinstance(shown.item, Placement)
            for material in shown.item.materials
        }

    # ---- world ----

    def _update_world(self) -> None:
        sent, world = self.sent, world_of(self.scene, self.layer)
        original = world.original if world is not None else None
        # In the frames of a render only the evaluated one has what is animated.
        evaluated = original.evaluated_get(self.depsgraph) if original is not None else None
        source = original.session_uid if original is not None else 0
        known, tagged = sent.world, self.tags.shading
        sun_lamp = self._sun_lamp() if follows_sun_lamp(evaluated) else None
        sun = b"" if sun_lamp is None else sun_lamp.tobytes()
        when = SkyTime(self.scene, frame_of(self.scene))
        if follows_time(evaluated):
            sun += np.float64(when.frame).tobytes()
        if follows_camera(evaluated):
            sun += camera_state(self.depsgraph)
        is_current = known.source == source and known.sun == sun
        is_current &= not (self.is_rerated or self.is_rescaled)
        if is_current and source not in tagged and known.shading.isdisjoint(tagged):
            return
        report = ConversionReport()
        key = identity.engine_id(original) if original is not None else ""
        made, suns = None, ()
        if evaluated is not None:
            tell(WORLD, evaluated, evaluated.name, report)
        if evaluated is not None:
            lights = not is_dark_world(evaluated, report)
            made, suns = convert_world(
                evaluated, key, sent.efficacy, report, sent.images, sun_lamp, lights, when
            )
            made = project_world(made, evaluated, self.depsgraph, sent.images, report)
        digest = content_digest(made) if made is not None else b""
        trees = shading_dependencies(original) if original is not None else frozenset()
        trees |= photos_of(evaluated, self.scene)
        gives_light = bool(suns) or (
            made is not None and (made.photo is not None or getattr(made, "luminance", 1.0) > 0.0)
        )
        colour, plane = colour_of_light(made), plane_of(made)
        sent.world = SentWorld(
            source, key, sun, digest, trees, report, gives_light, colour, suns, plane
        )
        self._update_items((*known.suns, *known.plane), (*suns, *plane))
        if digest == known.digest and (not digest or key == known.key):
            return
        self.world_changed = True
        sent.pictures.drop(known.key)
        if made is not None:
            self.worlds.append(sent.pictures.put(made))
        if known.digest and (made is None or known.key != key):
            self.removed.append(known.key)

    def _update_items(self, known, items) -> None:
        """Note what became of what comes with the world, suns and ground. ``known``, ``items``: of before and of now."""
        digests = {item.id: content_digest(item) for item in known}
        changed = [item for item in items if digests.get(item.id) != content_digest(item)]
        gone = digests.keys() - {item.id for item in items}
        self.worlds += changed
        self.removed += sorted(gone)
        self.world_changed |= bool(changed or gone)

    def _update_wishes(self) -> None:
        """Send what is wanted of simplifications where that is new. Views ask for no error, of which there is no share."""
        wishes = read_wishes(self.scene.lumenray.modelling, has_share=self.final)
        self.wishes_changed = wishes != self.sent.wishes
        if self.wishes_changed:
            self.sent.wishes = wishes
            self.wishes += [wishes] if wishes != Modelling() else []
            self.removed += [] if self.wishes else [wishes.id]

    def _sun_lamp(self) -> np.ndarray | None:
        """Unit vector to where the scene's Sun light shines from, the first one by name; None without one."""
        sent = self.sent
        lamps = [
            shown
            for shown in sent.shown.values()
            if shown.towards_sun is not None and shown.walk == sent.last_visit
        ]
        first = min(lamps, key=lambda shown: shown.name, default=None)
        return None if first is None else first.towards_sun


def _read_matrices(instances) -> bytes:
    """World matrices of all instances, 64 bytes each: compared whole, because instances do not always signal moves."""
    values = np.empty(16 * len(instances), np.float32)
    instances.foreach_get("matrix_world", values)
    return values.tobytes()


def _matrix_for(instance, needed) -> np.ndarray:
    """Matrix to the world in Blender units, as far as a material asks where the object stands."""
    return np.array(instance.matrix_world, np.float64) if PLACE in needed else np.eye(4)


def _is_special(source) -> bool:
    """Whether a light shines as a photometric file or a ray file says."""
    return is_luminaire(source) or is_rayset(source)
