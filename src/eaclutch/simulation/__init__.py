"""A run as the rig would log it: physics and the bench's noise, in the rig's format."""
