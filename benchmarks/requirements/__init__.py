"""What modelling only what a scene needs saves, and whether its bounds hold."""
