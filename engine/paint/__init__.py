"""Effect paints: their scattering computed from what their layers are made of."""
