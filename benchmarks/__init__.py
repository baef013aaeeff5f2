"""Speed and errors of this machine, measured side by side; a folder for each benchmark, `run` is its door."""
