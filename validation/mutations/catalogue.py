"""The faults that are tried: each must be found by the quick subset."""

from .faults import Mutation, Replace, Rewrite

_PANE = "materials.plugins:pane_optics"
_SURFACE = "luminaires.emitters.plugins:_surface_class"

MUTATIONS = (
    Mutation(
        "pi in luminous surfaces",
        "luminous surfaces are brighter by a factor of pi, as if their luminance were an exitance",
        (
            Rewrite(
                _SURFACE,
                "value = self.radiance.eval(si, active)",
                "value = self.radiance.eval(si, active) * dr.pi",
            ),
        ),
        ("C05.cie53", "C05.axis"),
    ),
    Mutation(
        "receiver's cosine",
        "the cosine of the angle of incidence is dropped",
        (
            Rewrite(
                "transport.paths.gather:response_of",
                "dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0), 0.0",
                "mi.Float(1.0), 0.0",
            ),
        ),
        ("C01.iso", "C21.point"),
    ),
    Mutation(
        "half a sphere",
        "the mean spherical illuminance is taken over half of the sphere's surface",
        (Rewrite("transport.paths.gather:response_of", "mi.Float(0.25)", "mi.Float(0.5)"),),
        ("C01.spatial",),
    ),
    Mutation(
        "C0 plane",
        "distributions of type C are turned by 90 degrees",
        (
            Rewrite(
                "luminaires.formats.lm63.reader:_distribution_c",
                "np.radians(content.vertical), intensity)",
                "np.radians(content.vertical), intensity, np.eye(3)[[1, 0, 2]] * [[-1], [1], [1]])",
            ),
        ),
        ("C02.level", "C03.quad"),
    ),
    Mutation(
        "quadrants",
        "planes stored from 0 to 90 degrees are repeated by turning instead of mirroring",
        (
            Replace(
                "luminaires.formats.symmetry:_IMAGES",
                '_IMAGES | {"quadrant": tuple((1.0, 90.0 * k) for k in range(4))}',
            ),
        ),
        ("C03.quad",),
    ),
    Mutation(
        "types A and B",
        "the polar axes of types A and B are exchanged",
        (
            Replace(
                "luminaires.coordinates:FRAMES",
                '{"C": FRAMES["C"], "A": FRAMES["B"], "B": FRAMES["A"]}',
            ),
        ),
        ("C04.B", "C04.A"),
    ),
    Mutation(
        "luminaire's turn",
        "a luminaire's rotation is not applied to its distribution",
        (
            Rewrite(
                "transport.compiled.compiled_light:_row_of",
                "rotation @ light.distribution.frame",
                "light.distribution.frame",
            ),
        ),
        ("C02.tilted", "C04.B"),
    ),
    Mutation(
        "V by x-bar",
        "the luminous efficiency is the colour-matching function x-bar",
        (
            Rewrite(
                "photometry.spectra:luminous_efficiency", "observer()[:, 1]", "observer()[:, 0]"
            ),
        ),
        ("C32.lines", "C32.sodium"),
    ),
    Mutation(
        "K_m of 673",
        "the maximum luminous efficacy is 673 lm/W instead of 683",
        (Replace("photometry.units:LUMINOUS_EFFICACY", "673.0"),),
        ("C32.lines", "C32.sodium"),
    ),
    Mutation(
        "lines on full nanometres",
        "emission lines are moved to the nearest full nanometre",
        (
            Rewrite(
                "photometry.spectra:emission_lines",
                "np.abs(wavelengths[..., None] - centres)",
                "np.abs(wavelengths[..., None] - np.round(centres))",
            ),
        ),
        ("C32.lines", "C32.sodium", "C32.xy"),
    ),
    Mutation(
        "Jacobian",
        "the density of hits of emitters is that per area, without distance squared over cosine",
        (
            Rewrite(
                "transport.paths.next_event:emitter_density",
                "emitter.pdf_direction(reference, ds, active)",
                "emitter.pdf_direction(reference, ds, active)"
                " * dr.abs(dr.dot(ds.d, ds.n)) / dr.maximum(dr.square(ds.dist), 1e-20)",
            ),
        ),
        ("C24.edge", "C05.horizon"),
    ),
    Mutation(
        "light counted twice",
        "light found by both strategies counts in full for each",
        (
            Rewrite(
                "transport.paths.next_event:power_heuristic",
                "dr.rcp(1.0 + dr.square(other / pdf))",
                "mi.Float(1.0)",
            ),
        ),
        ("C20.diffuse", "C19.env"),
    ),
    Mutation(
        "one-sided emitters",
        "one-sided emitters shine from both sides",
        (
            Rewrite(
                _SURFACE, 'props.get("two_sided", False)', 'props.get("two_sided", False) or True'
            ),
        ),
        ("C24.coplanar", "C24.edge"),
    ),
    Mutation(
        "shadows",
        "solid things cast none",
        (
            Rewrite(
                "transport.paths.visibility:transmittance",
                "active & ~scene.solid.ray_test(ray, active)",
                "mi.Bool(active)",
            ),
        ),
        ("C30.half", "C29.leak", "C09.form"),
    ),
    Mutation(
        "albedo squared",
        "reflectances of matt surfaces are squared",
        (
            Rewrite(
                "transport.compiled.surfaces:_row_spectrum",
                "make.spectrum(colour, PALETTE_STEPS)",
                "make.spectrum(colour, PALETTE_STEPS) ** 2",
            ),
        ),
        ("C20.diffuse", "C10.cube0.95"),
    ),
    Mutation(
        "three bounces",
        "paths end at their third surface",
        (Replace("transport.paths.path_loop:MAXIMUM_STEPS", "3"),),
        ("C10.cube0.95", "C20.diffuse"),
    ),
    Mutation(
        "roulette",
        "what survives Russian roulette is not divided by its chance",
        (
            Rewrite(
                "transport.paths.path_loop:PathLoop._play_roulette",
                "path.throughput / dr.maximum(survival, 1e-20)",
                "path.throughput",
            ),
        ),
        ("C10.cube0.95", "C20.diffuse"),
    ),
    Mutation(
        "polarisation",
        "both polarisations are averaged before the reflections inside a pane",
        (Rewrite(_PANE, "for r in (r_s, r_p):", "for r in (0.5 * (r_s + r_p),) * 2:"),),
        ("C07.slab88", "C07.beam"),
    ),
    Mutation(
        "angle of incidence",
        "panes transmit at every angle what they do at normal incidence",
        (Rewrite(_PANE, "dr.clip(cos_theta, 1e-4, 1.0)", "dr.clip(cos_theta, 1.0, 1.0)"),),
        ("C07.slab88", "C07.beam", "C13.1x1.sky5"),
    ),
    Mutation(
        "mirror",
        "the reflectance of mirrors counts twice for light on its way from a lamp",
        (
            Rewrite(
                "transport.compiled.mirrors:walk",
                "return at, ray.d, polar, value, going",
                "return at, ray.d, polar, value * value, going",
            ),
        ),
        ("C18.mirror_pt", "C18.mirror_total"),
    ),
    Mutation(
        "panes as mirrors",
        "panes are no mirrors to light on its way from a lamp",
        (
            Rewrite(
                "transport.compiled.known_mirrors:KnownMirrors.choose",
                "if with_panes or not p.is_pane",
                "if not p.is_pane",
            ),
        ),
        ("C38.two", "C39.one"),
    ),
    Mutation(
        "polarisation between panes",
        "light is unpolarised before every pane",
        (
            Rewrite(
                "transport.compiled.polarisation:Polarisation.meet",
                "factor = 1.0 + uneven * q",
                "factor = 1.0 + 0.0 * q",
            ),
        ),
        ("C38.two",),
    ),
    Mutation(
        "sun's azimuth",
        "the sky's sun stands in the north instead of the south",
        (
            Rewrite(
                "sky.plugin:_sky_class",
                "mi.Vector3f(*map(float, sun))",
                "mi.Vector3f(*map(float, sun * [1.0, -1.0, 1.0]))",
            ),
        ),
        ("C11.lum12", "C11.vertS"),
    ),
    Mutation(
        "gradation",
        "skies are as bright at the horizon as at the zenith",
        (
            Replace(
                "sky.cie:COEFFICIENTS", "{k: (0.0, -1.0, *v[2:]) for k, v in COEFFICIENTS.items()}"
            ),
        ),
        ("C12.1x1.sky1", "C11.lum12", "C11.Eh60"),
    ),
    Mutation(
        "ground",
        "no light comes from the ground before a window",
        (Rewrite("sky.skies:ground_luminance", "sky.ground_reflectance", "0.0"),),
        ("C14.2x1.ceiling",),
    ),
    Mutation(
        "cloudiness",
        "clear and overcast skies are mixed by the luminance of their zenith instead of their illuminance",
        (
            Rewrite(
                "sky.cie:pattern_of_cloudiness",
                "(1.0 - cloudiness) / integrate(clear, weigh=True)",
                "(1.0 - cloudiness) / integrate(overcast, weigh=True)",
            ),
        ),
        ("C46.open.c0.25", "C46.room.c0.5"),
    ),
    Mutation(
        "classes of weather",
        "a sky has the coefficients of the next darker class",
        (Replace("sky.perez:LUMINANCE", "np.concatenate([LUMINANCE[:1], LUMINANCE[:-1]])"),),
        ("C47.open.class3", "C47.room.class8"),
    ),
    Mutation(
        "first patch",
        "the first of Tregenza's patches begins in the north instead of having its middle there",
        (Rewrite("sky.measured:find_patches", "/ 360.0 + 0.5)", "/ 360.0)"),),
        ("C48.open.patches",),
    ),
    Mutation(
        "rows for nodes",
        "the first and last row of pixels of a picture of the surroundings lie at the poles",
        (
            Rewrite(
                "sky.picture_plugin:_picture_class",
                "from_pole = dr.atan2(plan, dr.abs(d.z)) * dr.inv_pi * height",
                "from_pole = dr.atan2(plan, dr.abs(d.z)) * dr.inv_pi * (height - 1.0) + 0.5",
            ),
        ),
        ("C37.cap16", "C37.ramp"),
    ),
    Mutation(
        "sun's disk",
        "the sun is twice as wide at the same luminance",
        (
            Rewrite(
                "transport.compiled.surroundings:make_surroundings",
                "2.0 * np.sin(0.5 * half) ** 2",
                "2.0 * np.sin(half) ** 2",
            ),
        ),
        ("C25.disk", "C21.beam"),
    ),
    Mutation(
        "shares of cones",
        "rays to lamps in glass are weighed as if each of an aim's cones were always chosen",
        (
            Rewrite(
                "transport.light_tracing.bent_lights:BentLights._density",
                "share * dr.inv_two_pi / cap",
                "dr.inv_two_pi / cap",
            ),
        ),
        ("C40.sensors10",),
    ),
    Mutation(
        "lamps in glass twice",
        "of luminous surfaces in glass both what is traced and what scattered rays meet counts",
        (
            Rewrite(
                "transport.light_tracing.light_paths:left_out_of",
                "if not starts & {SUN, SURFACE}:",
                "if not starts & {SUN}:",
            ),
        ),
        ("C40.map10", "C40.sensors10"),
    ),
    Mutation(
        "flux in glass",
        "flux that leaves glass is divided by the square of its index, as radiance is",
        (
            Rewrite(
                "transport.light_tracing.deposits:bend",
                "return bs, weight * dr.square(bs.eta)",
                "return bs, weight",
            ),
        ),
        ("C40.map10",),
    ),
    Mutation(
        "cosine of traced surfaces",
        "light that is traced from luminous surfaces is as strong along them as away from them",
        (
            Rewrite(
                "transport.light_tracing.emission_rays:EmissionRays._amount",
                "value *= dr.abs(dr.dot(surface.n, direction)) / dr.maximum(surface.pdf, 1e-30)",
                "value *= 1.0 / dr.maximum(surface.pdf, 1e-30)",
            ),
        ),
        ("C40.map10",),
    ),
    Mutation(
        "straight light twice",
        "light of suns and lamps on small spots is traced and found from there too",
        (
            Rewrite(
                "transport.light_tracing.straight_lights:StraightLights.__init__",
                "self._leave_out()",
                "pass",
            ),
        ),
        ("C41.hole",),
    ),
    Mutation(
        "guided rays as even ones",
        "rays that are guided to where light lands count as if they were spread evenly",
        (
            Rewrite(
                "transport.light_tracing.straight_lights:StraightLights._launch",
                "flux = flux / density",
                "flux = flux * 1.0",
            ),
        ),
        ("C42.point",),
    ),
    Mutation(
        "guide behind mirrors",
        "what rays read behind a mirror is weighed against a guide that could not have led there",
        (
            Rewrite(
                "transport.paths.path_loop:PathLoop._note_reference",
                "path.depth = dr.select(turned,",
                "path.depth = dr.select(anew,",
            ),
        ),
        ("C44.half",),
    ),
    Mutation(
        "Guth's index",
        "the glare rating takes the position index once instead of squared",
        (
            Rewrite(
                "analysis.glare:unified_glare_rating",
                "solid_angles / positions**2",
                "solid_angles / positions",
            ),
        ),
        ("C36.ugr",),
    ),
)
"""Each must be found by the quick subset."""
