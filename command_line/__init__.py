"""The command ``lumenray``; `main` is the door.

Each command is a module: ``add_command`` describes it to argparse, ``run`` takes its options and returns the exit code, or
raises a `LumenrayError` with one sentence.
"""
