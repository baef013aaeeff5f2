"""Makes the spectral tables that ship, of the data in colour-science."""
