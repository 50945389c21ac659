// The picking program in C++: an arm measures a part, picks it up, swings it into a post, and is told of that.
//
// Which kernel: VIRTUALROBOT_ADDRESS (default 127.0.0.1:50500) and VIRTUALROBOT_TOKEN (none for `--no-token`).

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include <grpcpp/grpcpp.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "virtualrobot/v1/collision.grpc.pb.h"
#include "virtualrobot/v1/kernel.grpc.pb.h"
#include "virtualrobot/v1/motion.grpc.pb.h"
#include "virtualrobot/v1/scene.grpc.pb.h"
#include "virtualrobot/v1/sensor.grpc.pb.h"

using namespace virtualrobot::v1;

std::string environment(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : otherwise;
}

// A call that the kernel has refused: the reason by its name, and what it tells beside.
struct Refusal : std::runtime_error {
  google::rpc::ErrorInfo info;

  explicit Refusal(const grpc::Status& status) : std::runtime_error(status.error_message()) {
    google::rpc::Status details;
    details.ParseFromString(status.error_details());
    for (const auto& detail : details.details()) detail.UnpackTo(&info);
  }
};

// Sends the token with a call.
void authorize(grpc::ClientContext& context) {
  const std::string token = environment("VIRTUALROBOT_TOKEN", "");
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
}

// Makes a call with one answer.
template <class Stub, class Request, class Answer>
Answer call(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Answer*),
            const Request& request) {
  grpc::ClientContext context;
  authorize(context);
  Answer answer;
  const grpc::Status status = (stub.*method)(&context, request, &answer);
  if (!status.ok()) throw Refusal(status);
  return answer;
}

// The kernel's services.
struct Kernel {
  std::shared_ptr<grpc::Channel> channel = grpc::CreateChannel(
      environment("VIRTUALROBOT_ADDRESS", "127.0.0.1:50500"), grpc::InsecureChannelCredentials());
  KernelService::Stub kernel{channel};
  SceneService::Stub scene{channel};
  SensorService::Stub sensor{channel};
  MotionService::Stub motion{channel};
  CollisionService::Stub collision{channel};
};

// A pose in the world, in meters, with the tool pointing down.
void set_pose(PoseGoal& goal, double x, double y, double z) {
  auto& pose = *goal.mutable_reference_t_tcp();
  pose.mutable_position()->set_x(x);
  pose.mutable_position()->set_y(y);
  pose.mutable_position()->set_z(z);
  pose.mutable_orientation()->set_x(std::sqrt(0.5));
  pose.mutable_orientation()->set_y(std::sqrt(0.5));
}

Move move_of_arm() {
  Move move;
  move.set_robot("arm");
  return move;
}

Move straight_to(double x, double y, double z) {
  Move move = move_of_arm();
  set_pose(*move.mutable_linear()->mutable_goal(), x, y, z);
  return move;
}

Motion start(Kernel& kernel, const Move& move, DisconnectPolicy unwatched = DISCONNECT_POLICY_STOP) {
  StartMotionRequest request;
  request.set_on_disconnect(unwatched);
  *request.mutable_spec()->add_moves() = move;
  return call(kernel.motion, &MotionService::Stub::StartMotion, request).motion();
}

// Waits for the end; a motion that nobody has watched for a second is cancelled.
Motion await_end(Kernel& kernel, Motion motion) {
  grpc::ClientContext context;
  authorize(context);
  WatchMotionRequest request;
  request.set_id(motion.id());
  auto stream = kernel.motion.WatchMotion(&context, request);
  for (WatchMotionResponse progress; stream->Read(&progress);) motion = progress.motion();
  if (const grpc::Status status = stream->Finish(); !status.ok()) throw Refusal(status);
  return motion;
}

// What the eye measures, in meters.
float measured(Kernel& kernel) {
  ReadSensorRequest request;
  request.set_sensor("eye");
  const auto answer = call(kernel.sensor, &SensorService::Stub::ReadSensor, request);
  float distance;
  std::memcpy(&distance, answer.reading().range().distances().data().data(), sizeof distance);
  return distance;
}

// The height of a node in the world, in meters: a row is x, y, z and a quaternion.
double height(Kernel& kernel, const std::string& node) {
  GetSceneRequest request;
  request.add_names(node);
  const auto answer = call(kernel.scene, &SceneService::Stub::GetScene, request);
  double row[7];
  std::memcpy(row, answer.world_t_node().data().data(), sizeof row);
  return row[2];
}

void work(const std::string& cell) {
  Kernel kernel;
  const auto info = call(kernel.kernel, &KernelService::Stub::GetInfo, GetInfoRequest());
  std::printf("kernel: %s\n", info.api_version().c_str());

  LoadSceneRequest scene;
  scene.set_text(cell);
  call(kernel.scene, &SceneService::Stub::LoadScene, scene);
  std::printf("measured: %.2f m\n", measured(kernel));

  Move above = move_of_arm();
  set_pose(*above.mutable_point_to_point()->mutable_pose(), 0.5, 0.0, 0.2);
  PlanMotionRequest plan;
  *plan.mutable_spec()->add_moves() = above;
  const auto planned = call(kernel.motion, &MotionService::Stub::PlanMotion, plan);
  std::printf("planned: %.2f s\n", planned.duration_seconds());
  const Motion moved = await_end(kernel, start(kernel, above));
  std::printf("moved: %s\n", MotionPhase_Name(moved.phase()).substr(std::strlen("MOTION_PHASE_")).c_str());

  await_end(kernel, start(kernel, straight_to(0.5, 0.0, 0.08)));
  ApplyRequest batch;
  auto& pick = *batch.add_commands()->mutable_pick_part();
  pick.set_robot("arm");
  pick.set_part("part");
  call(kernel.scene, &SceneService::Stub::Apply, batch);
  await_end(kernel, start(kernel, straight_to(0.5, 0.0, 0.28)));
  std::printf("picked: the part is at %.2f m\n", height(kernel, "part"));
  std::printf("measured: %.2f m\n", measured(kernel));

  grpc::ClientContext context;
  authorize(context);
  auto reports = kernel.collision.WatchCollisions(&context, WatchCollisionsRequest());
  WatchCollisionsResponse report;
  reports->Read(&report);  // what touches now
  Move swing = move_of_arm();
  (*swing.mutable_point_to_point()->mutable_joints()->mutable_joint_positions())["lbr_iiwa_joint_1"] = M_PI / 2;
  // Nobody watches the swing itself until it has touched something.
  const Motion swinging = start(kernel, swing, DISCONNECT_POLICY_CONTINUE);
  while (report.events().empty() || !report.events(0).has_begun()) {
    if (!reports->Read(&report)) throw Refusal(reports->Finish());
  }
  const auto& pair = report.events(0).begun().pair();
  const std::set<std::string> names{pair.first(), pair.second()};
  std::printf("touching: %s and %s\n", names.begin()->c_str(), names.rbegin()->c_str());
  context.TryCancel();
  await_end(kernel, swinging);

  Move misspelt = move_of_arm();
  (*misspelt.mutable_point_to_point()->mutable_joints()->mutable_joint_positions())["lbr_iiwa_jiont_4"] = 0.5;
  try {
    start(kernel, misspelt);
  } catch (const Refusal& refusal) {
    const auto& nearest = refusal.info.metadata().at("nearest");
    std::printf("refused: %s, nearest is %s\n", refusal.info.reason().c_str(), nearest.c_str());
  }
}

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "give the scene file: pick cell.yaml\n"), 2;
  std::stringstream cell;
  cell << std::ifstream(arguments[1]).rdbuf();
  try {
    work(cell.str());
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
