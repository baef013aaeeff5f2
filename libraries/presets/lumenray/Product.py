"""Products in a booth. EN 12464-1: 1000 lx where colours are inspected. We take 3000 lx for photographs."""

import bpy

settings = bpy.context.scene.lumenray

# A white ground that reflects 90 % has 860 cd/m² under 3000 lx, and is to be nearly white.
settings.exposure = "LUMINANCE"
settings.white_luminance = 1000.0
settings.ev100 = 8.0

# The picture is what counts: it ends by its own error, and what noise is left is taken out.
settings.render.stop = "ERROR"
settings.render.samples = 256
settings.render.error = 0.01
settings.render.time = 60.0
settings.render.use_denoising = True
settings.render.use_pass_luminance = True
settings.render.use_pass_illuminance = False

# A lumel every 2 cm, for things that are as large as a hand or an arm.
settings.bake.density = 50.0
settings.bake.use_error = True
settings.bake.error = 0.02
settings.bake.use_absolute = False
settings.bake.absolute = 5.0
settings.bake.use_time = False
settings.bake.time = 600.0
settings.bake.use_samples = False
settings.bake.samples = 1024

# 1000 lx of an inspection and 3000 lx of a photograph lie on the scale.
settings.viewport.automatic = False
settings.viewport.low = 0.0
settings.viewport.high = 4000.0
settings.viewport.logarithmic = False
settings.look.low = 0.0
settings.look.high = 4000.0
