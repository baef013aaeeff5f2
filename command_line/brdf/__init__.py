"""The commands ``lumenray brdf``: scattering files told, drawn, checked, converted and made; `commands` is the door."""
