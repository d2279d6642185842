"""The live rig: its serial protocol, a reader that loses nothing, capture sessions, and an emulated rig."""
