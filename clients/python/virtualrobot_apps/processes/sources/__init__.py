"""Sources of tool paths: ways on meshes, through points and of G-code, each as points with the surface's normals."""
