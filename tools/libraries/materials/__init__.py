"""Makes the materials that ship: scattering by the physics of their kind, their catalogue, pictures and Blender assets."""
