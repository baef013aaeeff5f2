"""The bundled office by this version and by another one, side by side: `run` is the door."""
