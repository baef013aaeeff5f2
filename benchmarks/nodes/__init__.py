"""What graphs of nodes cost beside pictures on surfaces, in the bundled office: `run` is the door."""
