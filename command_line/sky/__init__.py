"""The commands ``lumenray sky``: sun, skies and weather files told and drawn without Blender; `commands` is the door."""
