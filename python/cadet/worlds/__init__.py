"""Settings of a world: its streets, traffic, weather, and the user's own meshes and props."""
