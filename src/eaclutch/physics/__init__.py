"""What the clutch should do: laws, tables, the compiled solver, and one file an effect."""
