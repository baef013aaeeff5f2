"""Numbers made into pictures and figures for people: false colours, polar diagrams, glare, spectra."""
