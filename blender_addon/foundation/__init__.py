"""What every room of the extension stands on: identities, reports, shared settings, units, the engine's process."""
