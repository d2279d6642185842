"""The compiled solver: scalar numba functions over one run's ``Row``, and batches of them in parallel."""
