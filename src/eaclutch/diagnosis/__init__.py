"""Where the sim-to-real gap lies, which missing effect causes it, how far it closes."""
