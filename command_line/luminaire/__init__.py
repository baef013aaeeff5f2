"""The commands ``lumenray luminaire``: photometric files told, drawn and converted; `commands` is the door."""
