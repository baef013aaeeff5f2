"""The spectral engine. Never imports bpy: usable alone from Python, the command line or a worker process."""

VERSION = "0.1.0"
"""Version of the engine, stated in every result."""
