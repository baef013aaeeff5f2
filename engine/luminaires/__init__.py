"""Luminaires by their photometry: distributions, how much light they give, and what an engineer reads off them."""
