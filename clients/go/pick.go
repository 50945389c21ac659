// The picking program in Go: an arm measures a part, picks it up, swings it into a post, and is told of that.
//
// Which kernel: VIRTUALROBOT_ADDRESS (default 127.0.0.1:50500) and VIRTUALROBOT_TOKEN (none for `--no-token`).
package main

import (
	"context"
	"encoding/binary"
	"errors"
	"fmt"
	"io"
	"math"
	"os"
	"sort"
	"strings"

	"google.golang.org/genproto/googleapis/rpc/errdetails"
	"google.golang.org/grpc"
	"google.golang.org/grpc/encoding"
	"google.golang.org/grpc/metadata"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/proto"
	pb "virtualrobot/v1"
)

// codec is for gRPC before 1.36, as Debian 12 has it, which expects messages of the older generator.
type codec struct{}

func (codec) Name() string { return "proto" }
func (codec) Marshal(message interface{}) ([]byte, error) {
	return proto.Marshal(message.(proto.Message))
}
func (codec) Unmarshal(data []byte, message interface{}) error {
	return proto.Unmarshal(data, message.(proto.Message))
}

func init() { encoding.RegisterCodec(codec{}) }

// Kernel has the services that this program calls, and a context that carries the token.
type Kernel struct {
	ctx       context.Context
	kernel    pb.KernelServiceClient
	scene     pb.SceneServiceClient
	sensor    pb.SensorServiceClient
	motion    pb.MotionServiceClient
	collision pb.CollisionServiceClient
}

// must ends the program with an error, which a caller above turns into a line.
func must(err error) {
	if err != nil {
		panic(err)
	}
}

// pose returns a goal in the world, in meters, with the tool pointing down.
func pose(x, y, z float64) *pb.PoseGoal {
	half := math.Sqrt(0.5)
	return &pb.PoseGoal{ReferenceTTcp: &pb.Pose{
		Position:    &pb.Vector3{X: x, Y: y, Z: z},
		Orientation: &pb.Quaternion{X: half, Y: half},
	}}
}

func straightTo(goal *pb.PoseGoal) *pb.Move {
	return &pb.Move{Robot: "arm", Move: &pb.Move_Linear{Linear: &pb.Linear{Goal: goal}}}
}

func toPose(goal *pb.PoseGoal) *pb.Move {
	to := &pb.PointToPoint{Goal: &pb.PointToPoint_Pose{Pose: goal}}
	return &pb.Move{Robot: "arm", Move: &pb.Move_PointToPoint{PointToPoint: to}}
}

func toJoint(name string, radians float64) *pb.Move {
	joints := &pb.JointGoal{JointPositions: map[string]float64{name: radians}}
	to := &pb.PointToPoint{Goal: &pb.PointToPoint_Joints{Joints: joints}}
	return &pb.Move{Robot: "arm", Move: &pb.Move_PointToPoint{PointToPoint: to}}
}

func (k *Kernel) start(move *pb.Move, unwatched pb.DisconnectPolicy) (*pb.Motion, error) {
	spec := &pb.MotionSpec{Moves: []*pb.Move{move}}
	answer, err := k.motion.StartMotion(k.ctx, &pb.StartMotionRequest{Spec: spec, OnDisconnect: unwatched})
	return answer.GetMotion(), err
}

// awaitEnd waits for the end; a motion that nobody has watched for a second is cancelled.
func (k *Kernel) awaitEnd(motion *pb.Motion) *pb.Motion {
	stream, err := k.motion.WatchMotion(k.ctx, &pb.WatchMotionRequest{Id: motion.Id})
	must(err)
	for {
		progress, err := stream.Recv()
		if errors.Is(err, io.EOF) {
			return motion
		}
		must(err)
		motion = progress.Motion
	}
}

func (k *Kernel) move(move *pb.Move) *pb.Motion {
	motion, err := k.start(move, pb.DisconnectPolicy_DISCONNECT_POLICY_STOP)
	must(err)
	return k.awaitEnd(motion)
}

// measured returns what the eye measures, in meters.
func (k *Kernel) measured() float32 {
	answer, err := k.sensor.ReadSensor(k.ctx, &pb.ReadSensorRequest{Sensor: "eye"})
	must(err)
	return math.Float32frombits(binary.LittleEndian.Uint32(answer.Reading.GetRange().Distances.Data))
}

// height returns that of a node in the world, in meters: a row is x, y, z and a quaternion.
func (k *Kernel) height(node string) float64 {
	answer, err := k.scene.GetScene(k.ctx, &pb.GetSceneRequest{Names: []string{node}})
	must(err)
	return math.Float64frombits(binary.LittleEndian.Uint64(answer.WorldTNode.Data[16:]))
}

func (k *Kernel) work(scene string) {
	info, err := k.kernel.GetInfo(k.ctx, &pb.GetInfoRequest{})
	must(err)
	fmt.Println("kernel:", info.ApiVersion)

	_, err = k.scene.LoadScene(k.ctx, &pb.LoadSceneRequest{Text: scene})
	must(err)
	fmt.Printf("measured: %.2f m\n", k.measured())

	above := toPose(pose(0.5, 0.0, 0.2))
	plan, err := k.motion.PlanMotion(k.ctx, &pb.PlanMotionRequest{Spec: &pb.MotionSpec{Moves: []*pb.Move{above}}})
	must(err)
	fmt.Printf("planned: %.2f s\n", plan.DurationSeconds)
	fmt.Println("moved:", strings.TrimPrefix(k.move(above).Phase.String(), "MOTION_PHASE_"))

	k.move(straightTo(pose(0.5, 0.0, 0.08)))
	pick := &pb.Command{Command: &pb.Command_PickPart{PickPart: &pb.PickPart{Robot: "arm", Part: "part"}}}
	_, err = k.scene.Apply(k.ctx, &pb.ApplyRequest{Commands: []*pb.Command{pick}})
	must(err)
	k.move(straightTo(pose(0.5, 0.0, 0.28)))
	fmt.Printf("picked: the part is at %.2f m\n", k.height("part"))
	fmt.Printf("measured: %.2f m\n", k.measured())

	reports, err := k.collision.WatchCollisions(k.ctx, &pb.WatchCollisionsRequest{})
	must(err)
	report, err := reports.Recv() // what touches now
	must(err)
	// Nobody watches the swing itself until it has touched something.
	swing, err := k.start(toJoint("lbr_iiwa_joint_1", math.Pi/2), pb.DisconnectPolicy_DISCONNECT_POLICY_CONTINUE)
	must(err)
	for len(report.Events) == 0 || report.Events[0].GetBegun() == nil {
		report, err = reports.Recv()
		must(err)
	}
	pair := report.Events[0].GetBegun().Pair
	names := []string{pair.First, pair.Second}
	sort.Strings(names)
	fmt.Println("touching:", strings.Join(names, " and "))
	k.awaitEnd(swing)

	_, err = k.start(toJoint("lbr_iiwa_jiont_4", 0.5), pb.DisconnectPolicy_DISCONNECT_POLICY_STOP)
	for _, detail := range status.Convert(err).Details() {
		if refusal, ok := detail.(*errdetails.ErrorInfo); ok {
			fmt.Printf("refused: %s, nearest is %s\n", refusal.Reason, refusal.Metadata["nearest"])
		}
	}
}

func main() {
	defer func() {
		if err := recover(); err != nil {
			fmt.Fprintln(os.Stderr, err)
			os.Exit(1)
		}
	}()
	if len(os.Args) != 2 {
		panic("give the scene file: pick cell.yaml")
	}
	scene, err := os.ReadFile(os.Args[1])
	must(err)
	address := os.Getenv("VIRTUALROBOT_ADDRESS")
	if address == "" {
		address = "127.0.0.1:50500"
	}
	connection, err := grpc.Dial(address, grpc.WithInsecure())
	must(err)
	defer connection.Close()
	ctx := context.Background()
	if token := os.Getenv("VIRTUALROBOT_TOKEN"); token != "" {
		ctx = metadata.AppendToOutgoingContext(ctx, "authorization", "Bearer "+token)
	}
	kernel := &Kernel{
		ctx:       ctx,
		kernel:    pb.NewKernelServiceClient(connection),
		scene:     pb.NewSceneServiceClient(connection),
		sensor:    pb.NewSensorServiceClient(connection),
		motion:    pb.NewMotionServiceClient(connection),
		collision: pb.NewCollisionServiceClient(connection),
	}
	kernel.work(string(scene))
}
