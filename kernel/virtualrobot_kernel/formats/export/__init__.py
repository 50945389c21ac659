"""What is written for other programs: a part of the world as glTF, a robot as URDF."""
