"""Exhibitions. Museums keep what light harms most at 50 lx, and what it harms less at 200 lx."""

import bpy

settings = bpy.context.scene.lumenray

# A passe-partout that reflects 80 % has 51 cd/m² under 200 lx.
settings.exposure = "LUMINANCE"
settings.white_luminance = 100.0
settings.ev100 = 8.0

# Illuminance stands beside the picture, so that limits of exhibits can be checked in it.
settings.render.stop = "SAMPLES"
settings.render.samples = 128
settings.render.error = 0.02
settings.render.time = 60.0
settings.render.use_denoising = False
settings.render.use_pass_luminance = True
settings.render.use_pass_illuminance = True

# A lumel every 5 cm tells a picture from the wall around it; 1 % because limits are not to be exceeded.
settings.bake.density = 20.0
settings.bake.use_error = True
settings.bake.error = 0.01
settings.bake.use_absolute = False
settings.bake.absolute = 1.0
settings.bake.use_time = False
settings.bake.time = 600.0
settings.bake.use_samples = False
settings.bake.samples = 1024

# 50 and 200 lx are told apart; exhibits that light does not harm may have more, and 300 lx is our choice of a top.
settings.viewport.automatic = False
settings.viewport.low = 0.0
settings.viewport.high = 300.0
settings.viewport.logarithmic = False
settings.look.low = 0.0
settings.look.high = 300.0
