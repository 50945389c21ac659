"""A plugin that raises when it is imported."""

raise RuntimeError("the licence of this plugin has expired")
