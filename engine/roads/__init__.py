"""Road lighting as EN 13201-3 and CIE 140 compute it: surfaces, installations, luminances and glare that drivers see."""
