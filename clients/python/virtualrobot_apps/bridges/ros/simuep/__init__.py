"""SimUEP-Robotics (OTC Brasil 2013): its scene files, and its topics and services, on a kernel's world."""
