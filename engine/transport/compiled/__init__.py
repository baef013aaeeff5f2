"""The scene as the estimators see it: Mitsuba objects, and the tables of lights and mirrors beside them."""
