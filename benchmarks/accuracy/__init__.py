"""Error over time of sensors, pictures and the live view, beside Radiance and Cycles."""
