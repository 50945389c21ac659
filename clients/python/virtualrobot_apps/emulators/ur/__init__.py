"""Emulated controller of Universal Robots: dashboard, scripts and Real-Time Data Exchange (RTDE), by TCP."""
