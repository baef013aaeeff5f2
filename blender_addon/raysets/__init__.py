"""Ray files as lights of Blender: settings, preparation in the background, conversion for the engine."""
