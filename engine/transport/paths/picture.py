"""The picture job: camera rays, many passes, even and odd halves, extra passes at the pixels' centres."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...accuracy.estimate import Accumulator
from ...accuracy.stopping import Clock
from ...arrays import average
from ...errors import Cancelled, SceneError
from ...scene.camera import Camera, Projection
from ..compiled.compile import CompiledScene
from ..compiled.textures import is_spectral
from ..rays import spawn_ray
from . import gather
from . import path_loop as paths
from .light_learning import PILOT_LANES, PILOT_POINTS, learn
from .sampler import hash_words, random_stream, sobol_pair
from .wavelengths import WavelengthSampler

LANES = 1 << 18
"""Paths per launch; a picture's paths are dearer than a receiver's."""

GROUPS = 2
"""Even and odd half."""

DEEPEST = 8
"""Most samples per pixel and half in one pass."""

BELIEVED = 8
"""Samples per pixel below which the error is not believed enough to stop by it: of so few it is too noisy itself."""

FILTER_RADIUS = 0.75
"""Half width of the pixel filter, a tent; it is sampled, so that pixels stay independent. [pixel]"""

FAR = 1e10
"""Depth where nothing is seen, Blender's own value. [m]"""

BAND_RANGE = (380.0, 780.0)
"""Wavelengths that the bands cover. [nm]"""

LONGEST_WAY = 1000
"""Surfaces that a ray of the camera is followed through on its way out."""

MAXIMUM_PIXELS = 1 << 28
"""Largest picture."""


class Film:
    """Camera as numbers on the device: makes rays from film positions."""

    def __init__(self, camera: Camera, origin):
        self.camera = camera
        frame = np.asarray(camera.frame, dtype=np.float64)
        position = frame[:3, 3] - origin
        self.axes = [
            mi.Vector3f(*map(float, frame[:3, i] / np.linalg.norm(frame[:3, i]))) for i in range(3)
        ]
        self.position = mi.Point3f(*map(float, position))
        self.lens = mi.Float(camera.aperture_radius)
        self.focus = mi.Float(max(camera.focus_distance, 1e-6))
        self.clip = mi.Float(camera.clip_start)
        self.size = mi.Vector2f(camera.width, camera.height)
        self.width = mi.UInt32(camera.width)
        self.extent = mi.Vector2f(float(camera.extent_x), float(camera.extent_y))
        self.shift = mi.Vector2f(float(camera.shift_x), float(camera.shift_y))
        self.low = mi.Vector2f(float(camera.longitude[0]), float(camera.latitude[0]))
        self.high = mi.Vector2f(float(camera.longitude[1]), float(camera.latitude[1]))
        # As data, so that another view or size meets the same compiled kernel.
        dr.make_opaque(self.axes, self.position, self.lens, self.focus, self.clip, self.size)
        dr.make_opaque(self.width, self.extent, self.shift, self.low, self.high)

    def _to_world(self, x, y, z):
        return self.axes[0] * x + self.axes[1] * y + self.axes[2] * z

    def forward(self):
        """Direction of view."""
        return -self.axes[2]

    def ray(self, x, y, lens_sample):
        """Ray through a film position (pixels from the lower left corner)."""
        camera = self.camera
        u = x / self.size.x - 0.5
        v = y / self.size.y - 0.5
        if camera.projection is Projection.EQUIRECTANGULAR:
            longitude = dr.lerp(self.low.x, self.high.x, u + 0.5)
            latitude = dr.lerp(self.low.y, self.high.y, v + 0.5)
            cos_lat = dr.cos(latitude)
            direction = self._to_world(
                dr.sin(longitude) * cos_lat, dr.sin(latitude), -dr.cos(longitude) * cos_lat
            )
            return mi.Ray3f(self.position, direction)
        px = u * self.extent.x + self.shift.x
        py = v * self.extent.y + self.shift.y
        if camera.projection is Projection.ORTHOGRAPHIC:
            start = self.position + self._to_world(px, py, 0.0)
            return mi.Ray3f(start + self.forward() * self.clip, self.forward())
        start = self.position
        direction = self._to_world(px, py, -1.0)
        if camera.aperture_radius > 0.0:
            on_lens = mi.warp.square_to_uniform_disk_concentric(lens_sample) * self.lens
            shift = self._to_world(on_lens.x, on_lens.y, 0.0)
            direction = direction * self.focus - shift
            start = start + shift
        direction = dr.normalize(direction)
        along = dr.dot(direction, self.forward())
        return mi.Ray3f(start + direction * (self.clip / along), direction)


def render(scene: CompiledScene, camera: Camera, settings, progress=None, cancelled=lambda: False):
    """Render until the rule of ``settings`` is met.

    Returns
    -------
    (dict, int)    Fields of `session.Picture` but the provenance, and the samples per pixel.

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    SceneError    The picture's size is not usable.
    """
    pixels = camera.width * camera.height
    if camera.width < 1 or camera.height < 1 or pixels > MAXIMUM_PIXELS:
        raise SceneError(f"a picture of {camera.width} x {camera.height} pixels cannot be rendered")
    film = Film(camera, scene.origin)
    layers = _first_layers(scene, film)
    learn_lights(scene, film)
    job = PictureJob(scene, film, settings)
    clock = Clock(settings.rule, "picture")
    sums = Accumulator(GROUPS, (pixels, job.channels))
    error = float("inf")
    while True:
        batch = job.batch(pixels, sums.samples)
        new = np.zeros((GROUPS, pixels, job.channels))
        # At first one half after the other, so that the whole frame is there after one sample.
        halves = [range(GROUPS)] if sums.samples else [range(1), range(1, GROUPS)]
        for number, groups in enumerate(halves):
            per_launch = max(LANES // (len(groups) * batch), 1)
            for first in range(0, pixels, per_launch):
                if cancelled():
                    raise Cancelled("cancelled")
                count = min(per_launch, pixels - first)
                made = job.launch(first, count, batch, sums.samples, groups)
                new[groups.start : groups.stop, first : first + count] = made
                if progress is not None:
                    share = (number + (first + count) / pixels) / len(halves)
                    state = clock.progress(int((sums.samples + share * batch) * GROUPS), error)
                    known = first + count if number else 0
                    # The first pass shows what it has; later ones replace the whole picture.
                    progress(state, None if sums.samples else _snapshot(camera, new, known))
        sums.add(new, batch)
        estimate = sums.estimate()
        error = relative_error(estimate.mean[:, 1], estimate.standard_error[:, 1])
        is_believed = estimate.samples >= BELIEVED
        finished = clock.is_done(estimate.samples, error if is_believed else float("inf"))
        if progress is not None:
            shape = (camera.height, camera.width, 3)
            progress(
                clock.progress(estimate.samples, error),
                lambda mean=estimate.mean, shape=shape: (
                    mean[:, :3].reshape(shape).astype(np.float32)
                ),
            )
        if finished:
            return _result(camera, job, estimate, error, layers), estimate.samples


def learn_lights(scene: CompiledScene, film: Film, lanes: int = PILOT_LANES) -> None:
    """Compare the lights where the camera looks."""
    learn(scene, *look(scene, film), gather.typical_wavelengths(), lanes)


def look(scene: CompiledScene, film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Some of the places that the camera sees, in the scene's frame, and normals there. (n, 3) [m], (n, 3)"""
    stream = mi.PCG32(size=4 * PILOT_POINTS, initstate=3)
    ray = film.ray(
        stream.next_float32() * film.size.x,
        stream.next_float32() * film.size.y,
        mi.Point2f(0.5, 0.5),
    )
    si = scene.solid.ray_intersect(ray)
    normal = si.n * dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0)
    seen = np.array(si.is_valid())
    points = np.stack([np.array(c) for c in si.p], axis=1)[seen]
    normals = np.stack([np.array(c) for c in normal], axis=1)[seen]
    return points, normals


def _snapshot(camera: Camera, sums: np.ndarray, both: int):
    """Return a function that gives the picture of the first pass as it is, (h, w, 3) X, Y, Z.

    ``sums``: one sample of each half; ``both``: number of pixels whose second half is there too.
    """

    def take():
        mean = sums[0, :, :3].copy()
        mean[:both] = sums[:, :both, :3].mean(axis=0)
        return mean.reshape(camera.height, camera.width, 3).astype(np.float32)

    return take


def relative_error(luminance: np.ndarray, standard_error: np.ndarray) -> float:
    """Root mean square over the pixels of their error over the larger of their own and the mean luminance.

    So a lamp in view counts by its own luminance, and its edge does not hide what happens elsewhere.
    """
    mean = luminance.mean()
    if mean <= 0.0:
        return float("inf")
    return float(np.sqrt(((standard_error / np.maximum(luminance, mean)) ** 2).mean()))


def _result(camera, job, estimate, error, layers) -> dict:
    shape = (camera.height, camera.width)
    mean = estimate.mean.reshape(*shape, -1).astype(np.float32)
    deviation = estimate.standard_error.reshape(*shape, -1).astype(np.float32)
    made = {
        "tristimulus": mean[..., :3],
        "luminance_error": deviation[..., 1],
        "relative_error": error,
        **layers,
    }
    if job.illuminance:
        made["illuminance"] = mean[..., 3]
        made["illuminance_error"] = deviation[..., 3]
    if job.bands:
        made["bands"] = mean[..., -job.bands :]
        made["band_edges"] = np.linspace(*BAND_RANGE, job.bands + 1)
    if job.transparent:
        first = 3 + int(job.illuminance)
        made["backdrop"] = mean[..., first : first + 3]
        made["coverage"] = np.clip(1.0 - mean[..., first + 3], 0.0, 1.0)
    return made


class PictureJob:
    """What one launch needs besides its range of pixels."""

    def __init__(self, scene: CompiledScene, film: Film, settings):
        self.scene, self.film = scene, film
        self.rule, self.seed = settings.rule, settings.seed
        self.illuminance = settings.illuminance
        self.spectral = is_spectral()
        self.bands = settings.bands
        response = "bands" if self.bands else "colour"
        self.sampler = WavelengthSampler(scene.mean_light, response) if self.spectral else None
        self.transparent = settings.transparent
        self.channels = 3 + int(self.illuminance) + 4 * int(self.transparent) + self.bands
        # Photometric transport carries luminance alone; the lamps' common spectrum gives colour and bands back.
        self.lamp_tristimulus, self.lamp_bands = _colour_of(scene.mean_light, self.bands)

    def batch(self, pixels: int, done: int) -> int:
        """Samples per pixel and half in the next pass, a power of two: one at first, more where one launch has the frame.

        ``done``: samples per pixel and half so far.
        """
        wanted = DEEPEST
        if self.rule.samples is not None:
            wanted = -(-self.rule.samples // GROUPS) - done
        limit = min(wanted, max(done, 1), DEEPEST, LANES // (GROUPS * pixels))
        return 1 << int(np.floor(np.log2(max(limit, 1))))

    def launch(
        self, first: int, count: int, batch: int, index: int, groups: range = range(GROUPS)
    ) -> np.ndarray:
        """Trace one range of pixels, both halves or one; return the sums of samples (len(groups), count, channels)."""
        scene = self.scene
        width = self.film.width
        seed = dr.opaque(mi.UInt32, int(self.seed) & 0xFFFFFFFF)
        lane = dr.arange(mi.UInt32, count * len(groups) * batch)
        # As data: one half alone meets the kernel of both.
        halves = dr.opaque(mi.UInt32, len(groups))
        sample = dr.opaque(mi.UInt32, int(index)) + lane % batch
        group = dr.opaque(mi.UInt32, groups.start) + (lane // batch) % halves
        pixel = dr.opaque(mi.UInt32, int(first)) + (lane // batch) // halves
        own_seed = hash_words(pixel, hash_words(group, seed))

        wavelengths = gather.draw_wavelengths(self.sampler, sample, own_seed)
        offset = _filter_offset(sobol_pair(sample, own_seed, gather.PAIR_FILM))
        x = mi.Float(pixel % width) + 0.5 + offset.x
        y = mi.Float(pixel // width) + 0.5 + offset.y
        ray = self.film.ray(x, y, sobol_pair(sample, own_seed, gather.PAIR_LENS))
        stream = random_stream(sample, own_seed)
        first_samples = (
            sobol_pair(sample, own_seed, gather.PAIR_LIGHT),
            sobol_pair(sample, own_seed, gather.PAIR_SCATTER),
        )
        radiance = paths.trace(
            scene,
            ray,
            wavelengths,
            stream,
            mi.Float(0.0),
            ray.o,
            mi.Bool(True),
            first=first_samples,
        )
        radiance = dr.select(dr.isfinite(radiance), radiance, 0.0)
        columns = self._colour(radiance, wavelengths)
        if self.illuminance:
            columns.append(self._illuminance(ray, wavelengths, sample, own_seed))
        if self.transparent:
            columns += self._backdrop(ray, wavelengths)
        sums = [dr.block_reduce(dr.ReduceOp.Add, c, batch) for c in columns]
        bands = None
        if self.bands:
            bands = self._band_sums(radiance, wavelengths, lane // batch, count * len(groups))
        dr.eval(sums, bands)
        made = np.stack([np.array(s, dtype=np.float64) for s in sums], axis=-1)
        if bands is not None:
            made = np.concatenate(
                [made, np.array(bands, dtype=np.float64).reshape(-1, self.bands)], axis=-1
            )
        return made.reshape(count, len(groups), self.channels).transpose(1, 0, 2)

    def _colour(self, radiance, wavelengths) -> list:
        if self.spectral:
            xyz = self.sampler.tristimulus(radiance, wavelengths)
            return [xyz.x, xyz.y, xyz.z]
        return [radiance[0] * float(c) for c in self.lamp_tristimulus]

    def _backdrop(self, ray, wavelengths) -> list:
        """X, Y, Z of the surroundings that rays of the camera reach straight, and the share of rays that do."""
        scene = self.scene
        passed = _way_out(scene, ray, wavelengths)
        if scene.surroundings is None:
            colour = [mi.Float(0.0)] * 3
        else:
            away = dr.zeros(mi.SurfaceInteraction3f)
            away.wi = -ray.d
            if self.spectral:
                away.wavelengths = wavelengths
            colour = self._colour(passed * scene.surroundings.eval(away), wavelengths)
        return [*colour, average(passed)]

    def _band_sums(self, radiance, wavelengths, row, rows):
        """Sum of spectral radiance by band, flat (rows * bands)."""
        sums = dr.zeros(mi.Float, rows * self.bands)
        if not self.spectral:
            for band, value in enumerate(self.lamp_bands):
                dr.scatter_add(sums, radiance[0] * float(value), row * self.bands + band)
            return sums
        width = (BAND_RANGE[1] - BAND_RANGE[0]) / self.bands
        density = self.sampler.density(wavelengths)
        for k in range(4):
            value = radiance[k] / (4.0 * density[k] * width)
            # A wavelength stands for the nanometre about it, which an edge between two bands may divide.
            start = (wavelengths[k] - 0.5 - BAND_RANGE[0]) / width
            first = dr.floor(start)
            beyond = dr.clip((start + 1.0 / width - first - 1.0) * width, 0.0, 1.0)
            for band, share in ((first, 1.0 - beyond), (first + 1.0, beyond)):
                inside = (band >= 0.0) & (band < self.bands) & (share > 0.0)
                index = mi.UInt32(dr.clip(band, 0, self.bands - 1))
                dr.scatter_add(sums, value * share, row * self.bands + index, inside)
        return sums

    def _illuminance(self, ray, wavelengths, sample, own_seed):
        """Illuminance of the first surface behind panes and bodies of lights, on the side that is seen."""
        si = _first_solid(self.scene, ray)
        valid = si.is_valid()
        faces = dr.dot(si.n, ray.d) < 0.0
        side = dr.select(faces, 1.0, -1.0)
        at = gather.receiver(
            si.p, si.sh_frame.n * side, si.n * side, wavelengths, self.scene.extent_at(si)
        )
        pair = gather.PAIR_FILM + 1
        value = gather.spectral_illuminance(
            self.scene,
            at,
            wavelengths,
            random_stream(sample, hash_words(own_seed, mi.UInt32(1))),
            sobol_pair(sample, own_seed, pair),
            sobol_pair(sample, own_seed, pair + 1),
            valid,
        )
        value = gather.photometric(self.sampler, value, wavelengths)
        return dr.select(valid & dr.isfinite(value), value, 0.0)


def _filter_offset(sample):
    """Offset within the pixel filter: a tent, sampled exactly, so that every sample counts alike. [pixel]"""

    def tent(u):
        low = u < 0.5
        root = dr.sqrt(dr.select(low, 2.0 * u, 2.0 * (1.0 - u)))
        return FILTER_RADIUS * dr.select(low, root - 1.0, 1.0 - root)

    return mi.Point2f(tent(sample.x), tent(sample.y))


def _colour_of(light: np.ndarray, bands: int) -> tuple[np.ndarray, np.ndarray]:
    """X, Y, Z (Y = 1) and band radiances per unit of luminance of a spectrum on the grid."""
    from ...photometry.spectra import GRID, observer
    from ...photometry.units import LUMINOUS_EFFICACY

    tristimulus = light @ observer()
    density = light / (LUMINOUS_EFFICACY * tristimulus[1])
    edges = np.linspace(*BAND_RANGE, bands + 1)
    means = [
        density[(a <= GRID) & (b > GRID)].mean() for a, b in zip(edges, edges[1:], strict=False)
    ]
    return tristimulus / tristimulus[1], np.array(means)


def _albedo(scene, si, valid) -> np.ndarray:
    """Diffuse reflectance in the red, green and blue, 1 where a surface has no matt part. (n, 3)"""
    if is_spectral():
        si.wavelengths = mi.Spectrum(610.0, 550.0, 460.0, 550.0)
    bsdf = scene.bsdf(si, valid)
    matt = valid & mi.has_flag(bsdf.flags(), mi.BSDFFlags.DiffuseReflection)
    value = bsdf.eval_diffuse_reflectance(si, matt)
    columns = [value[i] for i in range(3)] if is_spectral() else [value[0]] * 3
    return np.stack(
        [np.array(dr.select(matt, dr.clip(c, 0.0, 1.0), 1.0), dtype=np.float32) for c in columns],
        axis=-1,
    )


def _way_out(scene, ray, wavelengths):
    """Share of rays of the camera that leaves the scene straight, through panes and what the camera does not see."""

    def step(ray, share, active, steps):
        si = paths.closest_hit(scene, ray, active, looks=mi.Bool(True))
        if wavelengths is not None:
            si.wavelengths = wavelengths
        met = active & si.is_valid()
        passed = scene.bsdf(si, met).eval_null_transmission(si, met)
        if scene.hidden is not None:
            ids = dr.reinterpret_array(mi.UInt32, si.shape)
            passed = dr.select(dr.gather(mi.Bool, scene.hidden, ids, met), 1.0, passed)
        share = dr.select(met, share * passed, share)
        ray = dr.select(met, spawn_ray(scene, si, ray.d), ray)
        going = met & dr.any(share != 0.0) & (steps < LONGEST_WAY)
        return ray, dr.select(met & (steps >= LONGEST_WAY), 0.0, share), going, steps + 1

    _, share, _, _ = dr.while_loop(
        state=(mi.Ray3f(ray), mi.Spectrum(1.0), mi.Bool(True), mi.UInt32(0)),
        cond=lambda ray, share, active, steps: active,
        body=step,
        labels=("ray", "share", "active", "steps"),
    )
    return share


def _first_solid(scene, ray):
    """First surface that a camera's ray meets behind panes and bodies of lights."""
    hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
    if scene.shown is not None:
        other = scene.shown.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
        hit = dr.select(other.t < hit.t, other, hit)
    return scene.surface(hit, ray, mi.Bool(True))


def _first_layers(scene: CompiledScene, film: Film) -> dict:
    """Depth, normal and indices at the centres of the pixels."""
    camera = film.camera
    shape = (camera.height, camera.width)
    pixel = dr.arange(mi.UInt32, camera.width * camera.height)
    ray = film.ray(
        mi.Float(pixel % camera.width) + 0.5,
        mi.Float(pixel // camera.width) + 0.5,
        mi.Point2f(0.5, 0.5),
    )
    si = paths.closest_hit(scene, ray, mi.Bool(True), coherent=True, looks=mi.Bool(True))
    valid = si.is_valid()
    if camera.projection is Projection.EQUIRECTANGULAR:
        depth = dr.norm(si.p - film.position)
    else:
        depth = dr.dot(si.p - film.position, film.forward())
    normal = dr.select(valid, si.sh_frame.n * dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0), 0.0)
    layers = {
        "depth": np.array(dr.select(valid, depth, FAR), dtype=np.float32).reshape(shape),
        "normal": np.stack([np.array(c, dtype=np.float32) for c in normal], axis=-1).reshape(
            *shape, 3
        ),
    }
    # Behind panes the picture shows what stands there, so that guides the filters.
    beyond = _first_solid(scene, ray)
    layers["albedo"] = _albedo(scene, beyond, beyond.is_valid()).reshape(*shape, 3)
    ids = dr.reinterpret_array(mi.UInt32, si.shape)
    for name in ("object", "material"):
        table = scene.indices.get(name)
        values = mi.Float(0.0)
        if table is not None:
            values = dr.gather(mi.Float, table, ids, valid)
        layers[f"{name}_index"] = np.broadcast_to(
            np.array(values, dtype=np.float32), (shape[0] * shape[1],)
        ).reshape(shape)
    return layers
