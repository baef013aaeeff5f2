"""Files that hold results or are no light, material or ray set: pictures, glTF, checkpoints, spectra, sensors."""
