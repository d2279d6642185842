"""Design maps and the rest of the paper: sweeps, published comparisons, the finite-element check."""
