"""What is there: meshes, materials, lights, the eye."""
