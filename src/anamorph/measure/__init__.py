"""How far a frame is from the reference."""
