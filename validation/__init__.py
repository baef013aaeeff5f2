"""The validation suite: 48 cases with independent reference values, run through the engine's public door.

`reference` holds the values, `cases` state the scenes, `bench` runs them with an instrument (the engine, or a peer),
`verdict` judges by the pass rules, `report` writes what people read.
"""
