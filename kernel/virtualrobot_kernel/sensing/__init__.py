"""What sensors see of the world: its elements as shapes for rays, range sensors, cameras, and how things move."""
