"""SDFormat models and worlds, as Gazebo reads them."""
