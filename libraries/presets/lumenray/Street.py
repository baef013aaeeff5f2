"""Streets and squares. EN 13201-2: 15 lx on the mean in class P1, 20 lx in C2, 1 cd/m² on the road in M3."""

import bpy

settings = bpy.context.scene.lumenray

# Roads of the classes M1 to M3 have 1 to 2 cd/m²: with white at 5 they are grey, and brighter things are not burnt out.
settings.exposure = "LUMINANCE"
settings.white_luminance = 5.0
settings.ev100 = 8.0

# Roads are judged by luminance, and lit by few lamps far away.
settings.render.stop = "SAMPLES"
settings.render.samples = 128
settings.render.error = 0.02
settings.render.time = 60.0
settings.render.use_denoising = False
settings.render.use_pass_luminance = True
settings.render.use_pass_illuminance = True

# A lumel every 50 cm: for illuminance EN 13201-3 asks for points at most 3 m apart along the road and 1.5 m across.
settings.bake.density = 2.0
settings.bake.use_error = True
settings.bake.error = 0.02
settings.bake.use_absolute = False
settings.bake.absolute = 0.1
settings.bake.use_time = False
settings.bake.time = 600.0
settings.bake.use_samples = False
settings.bake.samples = 1024

# From about the minimum of class P5 (0.6 lx) to the mean of C0 (50 lx).
settings.viewport.automatic = False
settings.viewport.low = 0.5
settings.viewport.high = 50.0
settings.viewport.logarithmic = True
settings.look.low = 0.0
settings.look.high = 50.0
