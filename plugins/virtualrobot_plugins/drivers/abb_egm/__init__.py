"""The driver `abb_egm`: ABB robots by Externally Guided Motion."""

from virtualrobot_plugins.drivers.abb_egm.driver import AbbEgm, AbbEgmSettings

__all__ = ["AbbEgm", "AbbEgmSettings"]
