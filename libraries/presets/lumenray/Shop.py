"""Shops. EN 12464-1: 300 lx in sales areas, 500 lx at tills. We take 2000 lx for accents on goods."""

import bpy

settings = bpy.context.scene.lumenray

# Goods that reflect 60 % have 380 cd/m² under an accent of 2000 lx.
settings.exposure = "LUMINANCE"
settings.white_luminance = 400.0
settings.ev100 = 8.0

# Many narrow beams make more noise than an office has.
settings.render.stop = "SAMPLES"
settings.render.samples = 128
settings.render.error = 0.02
settings.render.time = 60.0
settings.render.use_denoising = False
settings.render.use_pass_luminance = True
settings.render.use_pass_illuminance = False

# A lumel every 8 cm shows the beam of a spot on a shelf.
settings.bake.density = 12.0
settings.bake.use_error = True
settings.bake.error = 0.02
settings.bake.use_absolute = False
settings.bake.absolute = 5.0
settings.bake.use_time = False
settings.bake.time = 600.0
settings.bake.use_samples = False
settings.bake.samples = 1024

# From 300 lx between the shelves to accents of 2000 lx.
settings.viewport.automatic = False
settings.viewport.low = 0.0
settings.viewport.high = 2000.0
settings.viewport.logarithmic = False
settings.look.low = 0.0
settings.look.high = 2000.0
