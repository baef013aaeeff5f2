"""The command `lumenray`: one module for each command; `main` is the door."""
