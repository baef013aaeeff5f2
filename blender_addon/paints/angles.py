"""Angles of the colours of paints."""

STRIP = (15, 25, 45, 75, 110)
"""Aspecular angles of the colours that panels show. [degree]"""
