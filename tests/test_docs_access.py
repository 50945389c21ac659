"""The page of access tells the roles as the contract has them."""

from __future__ import annotations

import re
from pathlib import Path

from virtualrobot.v1 import motion_pb2, scene_pb2, token_pb2
from virtualrobot_kernel.api.limits import described
from virtualrobot_kernel.api.roles import roles_of
from virtualrobot_kernel.api.server import SERVICES
from virtualrobot_kernel.api.token_table import Role

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "access.md").read_text("utf-8")


def cells_of(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().removeprefix("|").removesuffix("|").split("|")]


def table_below(head: str) -> dict[str, list[list[str]]]:
    """Return the names in backticks of each cell by the first cell's words, of the table with this head."""
    lines = PAGE.partition(f"{head}\n")[2].splitlines()[1:]
    body = lines[: next((place for place, line in enumerate(lines) if not line.startswith("|")), len(lines))]
    return {cells[0]: [re.findall(r"`(\w+)`", cell) for cell in cells[1:]] for cells in map(cells_of, body)}


def test_each_call_stands_below_the_role_that_it_needs() -> None:
    services = [service for module, _, _ in SERVICES for service in module.DESCRIPTOR.services_by_name.values()]
    said = table_below("| service | observer | operator | engineer | admin |")
    needs = {service.name: roles_of([service]) for service in services}
    assert {re.sub(r"\[(\w+)\].*", r"\1", name): cells for name, cells in said.items()} == {
        name: [[path.rpartition("/")[2] for path, needed in roles.items() if needed is role] for role in Role]
        for name, roles in needs.items()
    }


def test_each_command_and_step_stands_below_the_role_that_it_needs() -> None:
    said = table_below("| | operator | engineer |")
    for kind, name in ((scene_pb2.Command, "Commands of `Apply`"), (motion_pb2.ProgramStep, "Steps of programs")):
        needs = {
            field.name: field.GetOptions().Extensions[token_pb2.command_needs_role] or Role.OPERATOR  # pyright: ignore[reportArgumentType]
            for field in kind.DESCRIPTOR.fields
        }
        wanted = [[name for name, role in needs.items() if role == one] for one in (Role.OPERATOR, Role.ENGINEER)]
        assert said[name] == wanted


def test_the_table_of_limits_is_that_of_the_kernel() -> None:
    table = PAGE.partition("| limit | default | what is counted |\n")[2].partition("\n\n")[0].splitlines()[1:]
    assert table == [f"| `{name}` | {default:,} | {text} |" for name, default, text in described()]
