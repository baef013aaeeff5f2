"""A package for each library, with the command that makes its data."""
