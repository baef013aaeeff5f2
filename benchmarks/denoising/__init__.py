"""Denoised pictures: how far they are off, whether they keep means, beside Cycles and its denoiser at equal time."""
