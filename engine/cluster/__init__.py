"""Jobs over several machines: independent chunks that workers compute, merged to the same bits; `session` is the door."""
