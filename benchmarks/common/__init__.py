"""What benchmarks share: the machine, bars, plain shapes, other programs, output."""
