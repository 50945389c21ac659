"""The bundled components keep the laws that the test kit has for anybody's."""
