"""Whether clusters give the same bits whatever becomes of their workers, and how well two work together."""
