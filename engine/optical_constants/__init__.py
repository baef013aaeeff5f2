"""Refractive indices and spectra of matter over the wavelength: as data (curves), and as files state them (quantities)."""
