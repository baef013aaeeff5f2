"""The job that fills lux maps: cells, passes, path guiding, and the pilot that shares out samples."""
