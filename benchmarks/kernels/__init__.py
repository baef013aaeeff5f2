"""Kernels of pictures: how many are built, how long that takes, and which edits need others; `run` is the door."""
