"""The job that measures at sensors: full paths, or light that is sampled by kinds and read from cells."""
