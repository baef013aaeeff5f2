"""The commands ``lumenray spectrum``: files of spectra told and drawn without Blender; `commands` is the door."""
