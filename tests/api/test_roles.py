"""Roles over the contract: what each token may do, how the rest is refused, and what a withdrawn one ends."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import grpc
import pytest
import virtualrobot
from virtualrobot.cli import run
from virtualrobot.v1 import (
    collision_pb2,
    history_pb2,
    kernel_pb2,
    lease_pb2,
    motion_pb2,
    robot_pb2,
    scene_pb2,
    signal_pb2,
    token_pb2,
    view_pb2,
)
from virtualrobot_kernel.api.roles import commands_in, may_command, roles_of
from virtualrobot_kernel.api.server import SERVICES
from virtualrobot_kernel.api.token_table import Role

from tests.api.asking import IIWA, apply, box, create, ended, joints, load, refusal, set_signals, start
from tests.api.leasing import Holder, all_free, leases, slow
from tests.api.moving import ABORTED, CANCELLED, SUCCEEDED
from tests.api.reading import state
from tests.kernels import EMPTY_SCENE, KernelProcess, StartKernel, Stubs

METHODS = [
    (service, method)
    for module, _, _ in SERVICES
    for service in module.DESCRIPTOR.services_by_name.values()
    for method in service.methods
]
NEEDS = roles_of({service for service, _ in METHODS})


@pytest.fixture(scope="module")
def guarded(start_kernel: StartKernel) -> KernelProcess:
    return start_kernel(token=True)


@pytest.fixture
def admin(guarded: KernelProcess) -> Iterator[Stubs]:
    """Return stubs with the kernel's own token, in an empty world without other tokens."""
    stubs = guarded.stubs()
    all_free(stubs)
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    yield stubs
    for token in stubs.token.ListTokens(token_pb2.ListTokensRequest()).tokens:
        stubs.token.RevokeToken(token_pb2.RevokeTokenRequest(name=token.name))
    stubs.channel.close()


Given = Callable[[str], KernelProcess]


@pytest.fixture
def given(guarded: KernelProcess, admin: Stubs) -> Given:
    """Return a function that gives the kernel as it is reached with a new token of a role, which is its name."""

    def make(role: str) -> KernelProcess:
        request = token_pb2.CreateTokenRequest(name=role, role=f"ROLE_{role.upper()}")
        return replace(guarded, token=admin.token.CreateToken(request).secret)

    return make


def call(channel: grpc.Channel, path: str) -> Any:  # noqa: ANN401 the call
    """Make a call with an empty request; whatever the method, what is sent and answered is a stream on the wire."""
    return channel.stream_stream(path)(iter([b""]), timeout=60)


def test_every_call_says_which_role_it_needs() -> None:
    said = {
        f"/{service.full_name}/{method.name}": method.GetOptions().Extensions[token_pb2.needs_role]  # pyright: ignore[reportArgumentType]
        for service, method in METHODS
    }
    assert [path for path, role in said.items() if not role] == []


def test_calls_that_touch_robots_are_not_for_observers_and_commands_need_more_than_their_calls() -> None:
    for service, method in METHODS:
        needs = NEEDS[f"/{service.full_name}/{method.name}"]
        if method.GetOptions().Extensions[lease_pb2.needs_lease]:  # pyright: ignore[reportArgumentType]
            assert needs >= Role.OPERATOR
    # Where commands are looked at: each call that an operator may make and that carries commands needs a lease, too.
    for kind in (scene_pb2.Command, motion_pb2.ProgramStep):
        marked = [field.name for field in kind.DESCRIPTOR.fields if list(commands_in(with_field(kind, field.name)))]
        assert marked, kind


def test_no_stream_of_requests_carries_commands() -> None:
    """Commands are looked for in the one request of a call."""
    assert [method.name for _, method in METHODS if method.client_streaming and may_command(method.input_type)] == []
    assert may_command(scene_pb2.ApplyRequest.DESCRIPTOR)


def with_field(kind: Any, name: str) -> Any:  # noqa: ANN401 a message
    message = kind()
    getattr(message, name).SetInParent()
    return message


def test_each_role_may_make_its_calls_and_no_others(guarded: KernelProcess, given: Given) -> None:
    """Every call of the contract by every role: nothing is refused that may be called, and all else is, by name."""
    for role in (Role.OBSERVER, Role.OPERATOR, Role.ENGINEER):
        with given(role.word).channel() as channel:
            for path, needs in NEEDS.items():
                if role >= needs:
                    continue
                refused = refusal(lambda path=path, channel=channel: list(call(channel, path)))
                name = path.rpartition("/")[2]
                assert (refused.code, refused.reason) == (grpc.StatusCode.PERMISSION_DENIED, "ROLE_TOO_LOW"), path
                assert (refused.metadata["needs"], refused.metadata["has"]) == (needs.word, role.word)
                assert refused.message.startswith(f"{name} needs the role {needs.word!r}; the token {role.word!r} is ")


def test_an_observer_reads_watches_and_stops(admin: Stubs, given: Given) -> None:
    load(admin, IIWA, "arm")
    stubs = given("observer").stubs()
    info = stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest())
    assert (info.role, info.token_name) == (token_pb2.ROLE_OBSERVER, "observer")
    assert [node.name for node in stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes if node.HasField("robot")]
    watch = stubs.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest())
    next(watch)
    watch.cancel()
    plan = motion_pb2.PlanMotionRequest(spec=motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_1=0.1)]))
    stubs.motion.PlanMotion(plan)
    id = start(admin, slow("arm")).id
    stubs.motion.Stop(motion_pb2.StopRequest())
    assert ended(admin, id).phase == CANCELLED
    for refused in (
        lambda: start(stubs, slow("arm")),
        lambda: apply(stubs, create(box("box"))),
        lambda: set_signals(stubs, {"lamp": True}),
        lambda: stubs.view.UpdateView(view_pb2.UpdateViewRequest()),
        lambda: stubs.token.ListTokens(token_pb2.ListTokensRequest()),
    ):
        assert refusal(refused).reason == "ROLE_TOO_LOW"
    assert admin.kernel.GetInfo(kernel_pb2.GetInfoRequest()).role == token_pb2.ROLE_ADMIN


def test_an_operator_moves_what_it_has_leased_and_edits_nothing(admin: Stubs, given: Given) -> None:
    load(admin, IIWA, "arm")
    lamp = scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal_pb2.Signal(name="lamp")))
    apply(admin, lamp)
    kernel = given("operator")
    stubs = kernel.stubs()
    set_signals(stubs, {"lamp": True})
    refused = refusal(lambda: start(stubs, slow("arm")))
    assert (refused.reason, refused.metadata["robot"]) == ("ROLE_TOO_LOW", "arm")
    assert "'arm' is free: lease it" in refused.message
    speed = scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(robot="arm", factor=0.5))
    assert refusal(lambda: apply(stubs, speed)).metadata["robot"] == "arm"
    holder = Holder(kernel, "arm", owner="Ada")
    holder.apply(speed)
    target = motion_pb2.SetpointTarget(robot="arm", mode=motion_pb2.SETPOINT_MODE_POSITION)
    first = motion_pb2.StreamSetpointsRequest(target=target)
    *_, end = stubs.motion.StreamSetpoints(iter([first]), metadata=holder.metadata)
    assert end.motion.phase == SUCCEEDED
    assert refusal(lambda: list(stubs.motion.StreamSetpoints(iter([first])))).metadata["owner"] == "Ada"
    id = holder.start(slow("arm"))
    stubs.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=id))
    stubs.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=id))
    assert ended(stubs, id).phase == CANCELLED
    before = admin.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    for command in (
        create(box("box")),
        scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="arm")),
        lamp,
        scene_pb2.Command(set_joint_positions=scene_pb2.SetJointPositions(robot="arm")),
        scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings()),
    ):
        name = command.WhichOneof("command")
        refused = refusal(lambda command=command: holder.apply(command))
        assert (refused.reason, refused.metadata["command"], refused.metadata["needs"]) == (
            "ROLE_TOO_LOW",
            name,
            "engineer",
        )
    assert admin.scene.SaveScene(scene_pb2.SaveSceneRequest()).text == before
    holder.release()


def test_what_an_operator_may_not_command_it_may_not_have_programs_do(given: Given) -> None:
    """However deep the step is: in rounds, in branches, in programs that are called."""
    stubs = given("operator").stubs()
    step = motion_pb2.ProgramStep(attach=scene_pb2.AttachNode(name="a", parent="b"))
    pairs = motion_pb2.ProgramStep(set_allowed_pairs=collision_pb2.SetAllowedPairs())
    repeat = motion_pb2.ProgramStep(repeat=motion_pb2.RepeatStep(count=2, steps=[pairs]))
    specs = [
        motion_pb2.MotionSpec(steps=[step]),
        motion_pb2.MotionSpec(steps=[repeat]),
        motion_pb2.MotionSpec(programs={"other": motion_pb2.SubProgram(steps=[repeat])}),
    ]
    for spec in specs:
        refused = refusal(lambda spec=spec: stubs.motion.StartMotion(motion_pb2.StartMotionRequest(spec=spec)))
        assert (refused.reason, refused.metadata["needs"]) == ("ROLE_TOO_LOW", "engineer")
        more = motion_pb2.AppendMotionRequest(id="motion-1", steps=spec.steps, programs=spec.programs)
        assert refusal(lambda more=more: stubs.motion.AppendMotion(more)).reason == "ROLE_TOO_LOW"


def test_an_engineer_edits_and_moves_what_is_free_but_makes_no_tokens(given: Given) -> None:
    stubs = given("engineer").stubs()
    load(stubs, IIWA, "arm")
    steps = stubs.history.ListSteps(history_pb2.ListStepsRequest(), metadata=(("client-name", "cell"),)).steps
    assert steps[0].author.startswith("engineer with client at ipv4:127.0.0.1:")
    id = start(stubs, slow("arm")).id
    stubs.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=id))
    request = token_pb2.CreateTokenRequest(name="mine", role=token_pb2.ROLE_ADMIN)
    assert refusal(lambda: stubs.token.CreateToken(request)).metadata["needs"] == "admin"
    assert refusal(lambda: stubs.kernel.Shutdown(kernel_pb2.ShutdownRequest())).metadata["needs"] == "admin"


def test_a_withdrawn_token_ends_its_streams_and_leases_and_its_robots_stop(admin: Stubs, given: Given) -> None:
    load(admin, IIWA, "arm")
    kernel = given("operator")
    stubs = kernel.stubs()
    watch = stubs.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest())
    next(watch)
    holder = Holder(kernel, "arm")
    id = holder.start(slow("arm"))
    told: list[str] = []
    waiting = threading.Thread(target=lambda: told.append(refusal(lambda: [None for _ in holder.told]).message))
    waiting.start()
    admin.token.RevokeToken(token_pb2.RevokeTokenRequest(name="operator"))
    refused = refusal(lambda: [None for _ in watch])
    assert (refused.code, refused.reason) == (grpc.StatusCode.UNAUTHENTICATED, "UNAUTHENTICATED")
    assert "the token 'operator' was withdrawn" in refused.message
    waiting.join(60)
    assert told == [refused.message]
    end = ended(admin, id)
    assert (end.phase, end.end_cause) == (ABORTED, motion_pb2.END_CAUSE_LEASE_EXPIRED)
    assert "the token 'operator' was withdrawn" in end.end_reason
    assert leases(admin) == []
    assert refusal(lambda: stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest())).reason == "UNAUTHENTICATED"
    assert state(admin, "arm")


def test_an_admin_that_withdraws_its_own_token_is_answered(given: Given) -> None:
    stubs = given("admin").stubs()
    revoke = token_pb2.RevokeTokenRequest(name="admin")
    assert stubs.token.RevokeToken(revoke).token.role == token_pb2.ROLE_ADMIN
    assert refusal(lambda: stubs.token.RevokeToken(revoke)).reason == "UNAUTHENTICATED"


@pytest.mark.parametrize("name", ["", "a b", "ä", "x" * 51, "a/b", "a\n"])
def test_a_name_that_is_none_is_refused(admin: Stubs, name: str) -> None:
    request = token_pb2.CreateTokenRequest(name=name, role=token_pb2.ROLE_OBSERVER)
    assert refusal(lambda: admin.token.CreateToken(request)).reason == "INVALID_ARGUMENT"


def test_tokens_are_listed_without_what_they_are_and_names_are_given_once(admin: Stubs, given: Given) -> None:
    secret = given("observer").token
    listed = admin.token.ListTokens(token_pb2.ListTokensRequest())
    (token,) = listed.tokens
    assert (token.name, token.role) == ("observer", token_pb2.ROLE_OBSERVER)
    assert token.created_by.startswith("client at ") and token.create_time.seconds
    assert secret.encode() not in listed.SerializeToString()
    request = token_pb2.CreateTokenRequest(name="observer", role=token_pb2.ROLE_OBSERVER)
    assert refusal(lambda: admin.token.CreateToken(request)).reason == "NAME_TAKEN"
    nobody = token_pb2.RevokeTokenRequest(name="obsever")
    assert refusal(lambda: admin.token.RevokeToken(nobody)).metadata["nearest"] == "observer"
    no_role = token_pb2.CreateTokenRequest(name="other")
    assert refusal(lambda: admin.token.CreateToken(no_role)).reason == "INVALID_ARGUMENT"


def test_a_kernel_that_lets_everybody_in_makes_no_tokens(stubs: Stubs) -> None:
    assert stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest()).role == token_pb2.ROLE_ADMIN
    request = token_pb2.CreateTokenRequest(name="one", role=token_pb2.ROLE_OBSERVER)
    refused = refusal(lambda: stubs.token.CreateToken(request))
    assert refused.reason == "WRONG_STATE" and "--no-token" in refused.message


def test_the_client_makes_lists_and_withdraws_tokens(guarded: KernelProcess, admin: Stubs) -> None:
    with virtualrobot.connect(guarded.address, guarded.token) as client:
        assert (client.info.role, client.info.token_name) == ("admin", "")
        made = client.tokens.create("panel", "operator")
        assert made.secret not in repr(made) and made.created_by in repr(made)
        assert [(one.name, one.role) for one in client.tokens.list()] == [("panel", "operator")]
        with pytest.raises(virtualrobot.InvalidArgumentError, match="there are 'observer', 'operator'"):
            client.tokens.create("other", "king")
        with virtualrobot.connect(guarded.address, made.secret) as panel:
            assert (panel.info.role, panel.info.token_name) == ("operator", "panel")
            with pytest.raises(virtualrobot.RoleTooLowError) as error:
                panel.scene.add_part("crate", virtualrobot.box(0.1, 0.1, 0.1))
            assert error.value.metadata["needs"] == "engineer" and isinstance(error.value, PermissionError)
            assert client.tokens.revoke("panel").role == "operator"
            with pytest.raises(virtualrobot.AuthenticationError, match="wants its token"):
                panel.clock.read()


def test_the_command_line_makes_lists_and_withdraws_tokens(
    guarded: KernelProcess, admin: Stubs, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own, file = tmp_path / "own", tmp_path / "panel"
    own.write_text(guarded.token)

    def said(token: Path, *arguments: str) -> tuple[int, str]:
        code = run([*arguments, "--address", guarded.address, "--token-file", str(token)])
        words = capsys.readouterr()
        return code, words.out + words.err

    create = ("token", "create", "panel", "observer", "--out", str(file))
    assert said(own, *create) == (0, f"the token of the observer panel is in {file}\n")
    code, words = said(own, *create)
    assert code == 1 and f"{file} is there already; a token is written to a new file only" in words
    assert said(own, "token", "create", "panel", "observer", "--out", str(tmp_path / "no"))[0] == 1
    assert not (tmp_path / "no").exists()
    nowhere = tmp_path / "nope" / "no"
    assert f"cannot write {nowhere}: No such file or directory" in said(own, *create[:-1], str(nowhere))[1]
    code, words = said(own, "token", "list")
    assert code == 0 and words.startswith("panel  observer  20")
    code, words = said(file, "step")
    assert code == 1 and words.startswith("virtualrobot: SetClock needs the role 'operator'; the token 'panel' is an ")
    assert said(own, "token", "revoke", "panel") == (0, "withdrawn: panel, observer\n")
    assert said(file, "state")[0] == 1


@pytest.mark.long
def test_tokens_are_kept_in_the_folder_of_a_project(start_kernel: StartKernel, tmp_path: Path) -> None:
    kernel = start_kernel("--data", str(tmp_path / "cell"), token=True)
    request = token_pb2.CreateTokenRequest(name="panel", role=token_pb2.ROLE_OPERATOR)
    secret = kernel.stubs().token.CreateToken(request).secret
    assert kernel.end() == 0
    again = start_kernel("--data", str(tmp_path / "cell"), token=True)
    info = replace(again, token=secret).stubs().kernel.GetInfo(kernel_pb2.GetInfoRequest())
    assert (info.role, info.token_name) == (token_pb2.ROLE_OPERATOR, "panel")
