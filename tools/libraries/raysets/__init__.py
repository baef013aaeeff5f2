"""Makes the ray sets that ship, by tracing small models of lamps."""
