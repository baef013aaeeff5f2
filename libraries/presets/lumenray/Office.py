"""Offices. EN 12464-1: 500 lx on the task where people write and read, uniformity 0.6."""

import bpy

settings = bpy.context.scene.lumenray

# Paper that reflects 80 % has 127 cd/m² under 500 lx; 200 keeps a white ceiling and a window from burning out.
settings.exposure = "LUMINANCE"
settings.white_luminance = 200.0
settings.ev100 = 8.0

# Enough to look at a picture; its luminance can be read in cd/m².
settings.render.stop = "SAMPLES"
settings.render.samples = 64
settings.render.error = 0.02
settings.render.time = 60.0
settings.render.use_denoising = False
settings.render.use_pass_luminance = True
settings.render.use_pass_illuminance = False

# A lumel every 12.5 cm shows edges of shadows on desks; 2 % is far below what meters and luminaires differ by.
settings.bake.density = 8.0
settings.bake.use_error = True
settings.bake.error = 0.02
settings.bake.use_absolute = False
settings.bake.absolute = 5.0
settings.bake.use_time = False
settings.bake.time = 600.0
settings.bake.use_samples = False
settings.bake.samples = 1024

# The 500 lx lie in the middle of the scale.
settings.viewport.automatic = False
settings.viewport.low = 0.0
settings.viewport.high = 1000.0
settings.viewport.logarithmic = False
settings.look.low = 0.0
settings.look.high = 1000.0
