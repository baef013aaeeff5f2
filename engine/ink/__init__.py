"""Dense pigment layers: what light does in them by the wave equation, for particles packed as in a printed film.

Lengths are micrometres unless a name says otherwise, wavelengths of spectra nanometres as everywhere; time goes as
exp(-i omega t), so absorbing indices are n + i k. The door is `computed.compute`.
"""
