"""Light transport with Mitsuba and Dr.Jit: from a compiled scene to radiance, illuminance and lux maps."""
