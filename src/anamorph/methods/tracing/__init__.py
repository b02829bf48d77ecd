"""Light paths, a ray for every pixel: for the reference, for the tiles that a method doubts, and for inspection."""
