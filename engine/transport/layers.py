"""Shapes that rays are traced against, kept so that an edit costs what it changes.

Building the search tree of all triangles takes seconds where there are millions. So a layer holds two Mitsuba scenes
that are traced in the same kernel: a *still* one with everything that stood there when it was built, and a *hot* one with
what was edited since. A shape that leaves the still scene is not taken out of its tree but marked as gone, and rays go on
behind it. Now and then, and before long jobs, everything settles into a new still scene.

Kernels of graphics cards can trace one Mitsuba scene only: OptiX gives all others no hits. There the layers share one tree,
in which each goes on behind what belongs to another (`SharedLayer`).
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import table_size, upload

SETTLE_SHARE = 0.25
"""Share of edited triangles beyond which rebuilding is cheaper than tracing around them."""

SETTLE_TRIANGLES = 200_000
"""Edited triangles that are always bearable."""

SMALL_SHAPES, SMALL_TRIANGLES = 32, 50_000
"""Layers up to this size are simply built anew."""

GONE_STEP = 1e-5
"""Step behind a surface that is gone, relative to the largest coordinate plus 1 m."""


class Layer:
    """Shapes that are traced together.

    `add` and `remove` only note; `commit` makes the next trace see it.

    Parameters
    ----------
    pool : compiled.pool.SurfacePool    Knows the surfaces of the shapes.
    """

    def __init__(self, pool):
        self._pool = pool
        self._still = _scene([])
        self._hot = None
        self._gone = None
        self._still_shapes: dict[int, tuple[object, int]] = {}
        self._hot_shapes: dict[int, tuple[object, int]] = {}
        self._gone_ids: set[int] = set()
        self._is_fresh = True
        self._hot_changed = self._gone_changed = False

    def __len__(self) -> int:
        """Count of the shapes that are there."""
        return len(self._still_shapes) + len(self._hot_shapes) - len(self._gone_ids)

    @property
    def is_settled(self) -> bool:
        """Whether all shapes are in the still scene."""
        return not (self._hot_shapes or self._gone_ids or self._hot_changed)

    def add(self, shape, number: int, triangles: int, _twin: int = 0) -> None:
        """Add a shape. ``number``: its `pointer_id`; ``_twin``: as of `SharedLayer`."""
        if self._is_fresh:
            self._still_shapes[number] = (shape, triangles)
        else:
            self._hot_shapes[number] = (shape, triangles)
            self._hot_changed = True

    def remove(self, number: int) -> None:
        """Take a shape away."""
        if self._hot_shapes.pop(number, None) is not None:
            self._hot_changed = True
        elif self._is_fresh:
            self._still_shapes.pop(number)
        else:
            self._gone_ids.add(number)
            self._gone_changed = True

    def commit(self) -> bool:
        """Bring the traced scenes up to date; true when a large still one was built anew."""
        if self._is_fresh or self._is_small():
            self.settle()
            return False
        if self._is_overgrown():
            self.settle()
            return True
        if self._hot_changed:
            shapes = [shape for shape, _ in self._hot_shapes.values()]
            self._hot = _scene(shapes) if shapes else None
            self._hot_changed = False
        if self._gone_changed:
            # Hot shapes have higher numbers too, but only still ones are looked up.
            marks = np.zeros(table_size(max(self._still_shapes) + 1), dtype=bool)
            marks[list(self._gone_ids)] = True
            self._gone = upload(mi.Bool, marks)
            self._gone_changed = False
        return False

    def settle(self) -> None:
        """Build the still scene of all shapes."""
        if not self._is_fresh and self.is_settled:
            return
        shapes = {k: v for k, v in self._still_shapes.items() if k not in self._gone_ids}
        self._still_shapes = shapes | self._hot_shapes
        self._hot_shapes, self._gone_ids = {}, set()
        self._hot = self._gone = self._still = None
        self._still = _scene([shape for shape, _ in self._still_shapes.values()])
        self._is_fresh = self._hot_changed = self._gone_changed = False

    def replace(self, number: int) -> None:
        """Note that a shape itself was changed."""
        if number in self._hot_shapes:
            self._hot_changed = True
        elif not self._is_fresh:
            self._hot_shapes[number] = self._still_shapes[number]
            self._gone_ids.add(number)
            self._hot_changed = self._gone_changed = True

    def _is_small(self) -> bool:
        shapes = [*self._still_shapes.values(), *self._hot_shapes.values()]
        return len(shapes) <= SMALL_SHAPES and sum(n for _, n in shapes) <= SMALL_TRIANGLES

    def _is_overgrown(self) -> bool:
        still = sum(count for _, count in self._still_shapes.values())
        edited = sum(count for _, count in self._hot_shapes.values())
        edited += sum(self._still_shapes[number][1] for number in self._gone_ids)
        return edited > max(SETTLE_TRIANGLES, SETTLE_SHARE * still)

    # ---- tracing ----

    def ray_intersect_preliminary(self, ray, coherent=False, active=True):
        """Nearest hit, without its surface data."""
        active = mi.Bool(active)
        hit = nearest(self._still, self._find_gone(), ray, coherent, active)
        if self._hot is not None:
            other = self._hot.ray_intersect_preliminary(ray, mi.Bool(coherent), active)
            hit = dr.select(other.t < hit.t, other, hit)
        return hit

    def ray_intersect(self, ray, active=True):
        """Nearest surface."""
        hit = self.ray_intersect_preliminary(ray, False, active)
        return self._pool.interaction(hit, ray, active)

    def ray_test(self, ray, active=True):
        """Whether anything stands in the way."""
        active = mi.Bool(active)
        blocked = is_blocked(self._still, self._find_gone(), ray, active)
        if self._hot is not None:
            blocked |= self._hot.ray_test(ray, active & ~blocked)
        return blocked

    def _find_gone(self):
        """What tells of hits whether rays go on behind them, None where none do."""
        if self._gone is None:
            return None
        return lambda hit, active: (hit, active & _look_up(mi.Bool, self._gone, hit, active))


class SharedTree:
    """Mitsuba scene of the shapes of several layers, built anew when one of them has changed."""

    def __init__(self):
        self.shapes: dict[int, object] = {}
        self.scene = _scene([])
        self.version = 0
        self._is_stale = False

    def put(self, number: int, shape, is_twin: bool) -> None:
        """Take a shape in. ``is_twin``: whether one of the same triangles is in already."""
        if not is_twin:
            self.shapes[number] = shape
        self.touch()

    def drop(self, number: int) -> None:
        """Let a shape go."""
        self.shapes.pop(number, None)
        self.touch()

    def touch(self) -> None:
        """Note that something has changed."""
        self._is_stale = True

    def commit(self) -> None:
        """Bring the scene up to date."""
        if self._is_stale:
            self.scene = None
            self.scene = _scene(list(self.shapes.values()))
            self.version += 1
            self._is_stale = False


class SharedLayer:
    """As `Layer`, out of a tree that other layers are in too.

    Shapes of two layers that are nearer to each other than the step behind a surface are taken for one. What has the same
    triangles as a shape of another layer, its twin, is not in the tree: who meets the twin meets it.

    Parameters
    ----------
    pool : compiled.pool.SurfacePool    Knows the surfaces of the shapes.
    tree : SharedTree
    """

    is_settled = True

    def __init__(self, pool, tree: SharedTree):
        self._pool, self._tree = pool, tree
        self._own: dict[int, int] = {}
        self._names = None
        self._version = None

    def __len__(self) -> int:
        """Count of the shapes that are there."""
        return len(self._own)

    def add(self, shape, number: int, _triangles: int, twin: int = 0) -> None:
        """Add a shape. ``number``: its `pointer_id`; ``twin``: that of the same triangles in another layer, 0: none."""
        self._own[number] = twin or number
        self._tree.put(number, shape, bool(twin))

    def remove(self, number: int) -> None:
        """Take a shape away."""
        del self._own[number]
        self._tree.drop(number)

    def replace(self, number: int) -> None:
        """Note that a shape itself was changed."""
        self._tree.touch()

    def commit(self) -> bool:
        """Bring the tree up to date; never waits for a large one beside others."""
        self._tree.commit()
        return False

    def settle(self) -> None:
        """As `commit`."""
        self.commit()

    def ray_intersect_preliminary(self, ray, coherent=False, active=True):
        """Nearest hit, without its surface data."""
        return nearest(self._tree.scene, self._find_names(), ray, coherent, mi.Bool(active))

    def ray_intersect(self, ray, active=True):
        """Nearest surface."""
        hit = self.ray_intersect_preliminary(ray, False, active)
        return self._pool.interaction(hit, ray, active)

    def ray_test(self, ray, active=True):
        """Whether anything stands in the way."""
        return is_blocked(self._tree.scene, self._find_names(), ray, mi.Bool(active))

    def _find_names(self):
        """What tells of hits which shape of this layer they are and which are none, None where all are as the tree says."""
        if self._version != self._tree.version:
            self._names = None
            if self._own != {number: number for number in self._tree.shapes}:
                # By the number of what is met: that of the shape which it is here, 0 for none.
                names = np.zeros(table_size(max(self._tree.shapes, default=0) + 1), dtype=np.uint32)
                names[list(self._own.values())] = list(self._own)
                self._names = upload(mi.UInt32, names)
            self._version = self._tree.version
        if self._names is None:
            return None

        def name(hit, active):
            own = _look_up(mi.UInt32, self._names, hit, active)
            hit = mi.PreliminaryIntersection3f(hit)
            hit.shape = dr.select(own > 0, dr.reinterpret_array(mi.ShapePtr, own), hit.shape)
            return hit, active & hit.is_valid() & (own == 0)

        return name


def make_layers(pool, count: int, shares: bool) -> list[Layer] | list[SharedLayer]:
    """Return empty layers. ``shares``: whether kernels can trace one Mitsuba scene only."""
    if not shares:
        return [Layer(pool) for _ in range(count)]
    tree = SharedTree()
    return [SharedLayer(pool, tree) for _ in range(count)]


def _look_up(kind, table, hit, active):
    """Entry of a table by the number of the shape that was met."""
    number = dr.reinterpret_array(mi.UInt32, hit.shape)
    return dr.gather(kind, table, number, active & hit.is_valid())


def nearest(scene, find, ray, coherent, active):
    """Nearest hit of a Mitsuba scene.

    Parameters
    ----------
    find : callable or None    ``find(hit, active)``: the hit as it counts, and whether rays go on behind it; None: none do.
    """
    hit = scene.ray_intersect_preliminary(ray, mi.Bool(coherent), active)
    if find is None:
        return hit

    def onwards(hit, travelled, looking):
        reach = dr.max(dr.abs(ray(travelled + hit.t))) + 1.0
        travelled = dr.select(looking, travelled + hit.t + GONE_STEP * reach, travelled)
        rest = mi.Ray3f(ray)
        rest.o = ray(travelled)
        rest.maxt = ray.maxt - travelled
        following = scene.ray_intersect_preliminary(rest, mi.Bool(False), looking)
        following, goes_on = find(following, looking)
        hit = dr.select(looking, following, hit)
        return hit, travelled, goes_on

    hit, goes_on = find(hit, active)
    hit, travelled, _ = dr.while_loop(
        state=(hit, mi.Float(0.0), goes_on),
        cond=lambda hit, travelled, looking: looking,
        body=onwards,
        labels=("hit", "travelled", "looking"),
    )
    hit.t += travelled
    return hit


def is_blocked(scene, find, ray, active):
    """Whether anything of a Mitsuba scene stands in the way; parameters as of `nearest`."""
    if find is None:
        return scene.ray_test(ray, active)
    return active & nearest(scene, find, ray, False, active).is_valid()


def _scene(shapes):
    named = {f"s{i}": shape for i, shape in enumerate(shapes)}
    # Without the robust test a few rays in a million slip between triangles that share an edge: 1e-5 of the sky's
    # illuminance in the corner of a closed box.
    scene = {"type": "scene", "embree_use_robust_intersections": True, **named}
    return mi.load_dict(scene, optimize=False)
