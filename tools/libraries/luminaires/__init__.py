"""Makes the luminaires that ship: photometric files by formulas, their catalogue, pictures and Blender assets."""
