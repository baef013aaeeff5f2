"""What benchmarks share: the machine, bars, charts, documents, plain shapes, other programs, output."""
