"""From what a goniometer counts to a table of scattering."""
