"""EULUMDAT (.ldt): read by `reader`, written by `writer`."""
