"""What the bench produced: log formats, repair and quality, observables, gap, serial driver, emulator."""
