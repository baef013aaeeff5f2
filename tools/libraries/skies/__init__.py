"""Makes the spectral table of clear skies that ships, of the data in Mitsuba."""
