"""Node trees evaluated: numbers, colours and pictures over a surface."""
