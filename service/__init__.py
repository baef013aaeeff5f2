"""Scenes and jobs of several users, computed on one machine: `supervisor` computes, `web` answers; not in the zip."""
