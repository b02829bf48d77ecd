"""What light does at mirrors and glass, and the ray meshes that follow from it."""
