"""The plugin `models`: robots and grippers by name, from files of packages and from tables of our own."""

from virtualrobot_sdk.hookspecs import RegisterModel, hookimpl

from virtualrobot_plugins.models.tables import read_tables

api_version = "1.0"


@hookimpl
def virtualrobot_register_models(register: RegisterModel) -> None:
    """Make all models of the tables known."""
    for model in read_tables():
        register(model)
