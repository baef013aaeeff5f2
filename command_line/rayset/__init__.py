"""The commands ``lumenray rayset``: ray files told, drawn, reduced, converted, prepared; `commands` is the door."""
