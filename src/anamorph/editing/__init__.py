"""Turning, moving, bending and grinding the parts of a scene, which keep their exact surfaces."""
