"""Physics: what moves by forces, computed by an engine that is a component."""
