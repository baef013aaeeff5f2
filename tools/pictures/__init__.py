"""Pictures of the documents that are rendered, a module for each."""
