"""The second witness: paths from all lights that tell what gathering has missed."""
