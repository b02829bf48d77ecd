"""The graphics device: buffers, textures, passes, and the one shading function."""
