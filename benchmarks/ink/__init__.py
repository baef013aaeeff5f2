"""Dense pigment layers against reference values, what particles' sizes do to colours, and the cost."""
