"""Sealed campaigns from laws that the library does not know: generate, seal, score."""
