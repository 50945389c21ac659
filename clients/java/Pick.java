import com.google.protobuf.InvalidProtocolBufferException;
import com.google.rpc.ErrorInfo;
import io.grpc.ManagedChannel;
import io.grpc.Metadata;
import io.grpc.StatusRuntimeException;
import io.grpc.netty.NettyChannelBuilder;
import io.grpc.protobuf.StatusProto;
import io.grpc.stub.MetadataUtils;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Iterator;
import java.util.Locale;
import java.util.TreeSet;
import virtualrobot.v1.*;

/**
 * The picking program in Java: an arm measures a part, picks it up, swings it into a post, and is told of that.
 *
 * <p>Which kernel: VIRTUALROBOT_ADDRESS (default 127.0.0.1:50500) and VIRTUALROBOT_TOKEN (none for `--no-token`).
 */
public final class Pick {
  private final KernelServiceGrpc.KernelServiceBlockingStub kernel;
  private final SceneServiceGrpc.SceneServiceBlockingStub scene;
  private final SensorServiceGrpc.SensorServiceBlockingStub sensor;
  private final MotionServiceGrpc.MotionServiceBlockingStub motion;
  private final CollisionServiceGrpc.CollisionServiceBlockingStub collision;

  private Pick(ManagedChannel channel, String token) {
    Metadata metadata = new Metadata();
    if (!token.isEmpty()) {
      metadata.put(Metadata.Key.of("authorization", Metadata.ASCII_STRING_MARSHALLER), "Bearer " + token);
    }
    var withToken = MetadataUtils.newAttachHeadersInterceptor(metadata);
    kernel = KernelServiceGrpc.newBlockingStub(channel).withInterceptors(withToken);
    scene = SceneServiceGrpc.newBlockingStub(channel).withInterceptors(withToken);
    sensor = SensorServiceGrpc.newBlockingStub(channel).withInterceptors(withToken);
    motion = MotionServiceGrpc.newBlockingStub(channel).withInterceptors(withToken);
    collision = CollisionServiceGrpc.newBlockingStub(channel).withInterceptors(withToken);
  }

  /** Returns a goal in the world, in meters, with the tool pointing down. */
  private static PoseGoal pose(double x, double y, double z) {
    double half = Math.sqrt(0.5);
    return PoseGoal.newBuilder()
        .setReferenceTTcp(
            Pose.newBuilder()
                .setPosition(Vector3.newBuilder().setX(x).setY(y).setZ(z))
                .setOrientation(Quaternion.newBuilder().setX(half).setY(half)))
        .build();
  }

  private static Move straightTo(PoseGoal goal) {
    return Move.newBuilder().setRobot("arm").setLinear(Linear.newBuilder().setGoal(goal)).build();
  }

  private static Move toPose(PoseGoal goal) {
    return Move.newBuilder().setRobot("arm").setPointToPoint(PointToPoint.newBuilder().setPose(goal)).build();
  }

  private static Move toJoint(String name, double radians) {
    var joints = JointGoal.newBuilder().putJointPositions(name, radians);
    return Move.newBuilder().setRobot("arm").setPointToPoint(PointToPoint.newBuilder().setJoints(joints)).build();
  }

  private Motion start(Move move, DisconnectPolicy unwatched) {
    var spec = MotionSpec.newBuilder().addMoves(move);
    var request = StartMotionRequest.newBuilder().setSpec(spec).setOnDisconnect(unwatched);
    return motion.startMotion(request.build()).getMotion();
  }

  private Motion start(Move move) {
    return start(move, DisconnectPolicy.DISCONNECT_POLICY_STOP);
  }

  /** Waits for the end; a motion that nobody has watched for a second is cancelled. */
  private Motion awaitEnd(Motion started) {
    Motion latest = started;
    var request = WatchMotionRequest.newBuilder().setId(started.getId()).build();
    for (var progress = motion.watchMotion(request); progress.hasNext(); ) latest = progress.next().getMotion();
    return latest;
  }

  /** Returns what the eye measures, in meters. */
  private float measured() {
    var reading = sensor.readSensor(ReadSensorRequest.newBuilder().setSensor("eye").build()).getReading();
    ByteBuffer data = reading.getRange().getDistances().getData().asReadOnlyByteBuffer();
    return data.order(ByteOrder.LITTLE_ENDIAN).getFloat(0);
  }

  /** Returns the height of a node in the world, in meters: a row is x, y, z and a quaternion. */
  private double height(String node) {
    var found = scene.getScene(GetSceneRequest.newBuilder().addNames(node).build());
    return found.getWorldTNode().getData().asReadOnlyByteBuffer().order(ByteOrder.LITTLE_ENDIAN).getDouble(16);
  }

  private void work(String text) throws InvalidProtocolBufferException {
    System.out.println("kernel: " + kernel.getInfo(GetInfoRequest.getDefaultInstance()).getApiVersion());

    scene.loadScene(LoadSceneRequest.newBuilder().setText(text).build());
    System.out.printf("measured: %.2f m%n", measured());

    Move above = toPose(pose(0.5, 0.0, 0.2));
    var spec = MotionSpec.newBuilder().addMoves(above);
    var plan = motion.planMotion(PlanMotionRequest.newBuilder().setSpec(spec).build());
    System.out.printf("planned: %.2f s%n", plan.getDurationSeconds());
    Motion moved = awaitEnd(start(above));
    System.out.println("moved: " + moved.getPhase().name().replace("MOTION_PHASE_", ""));

    awaitEnd(start(straightTo(pose(0.5, 0.0, 0.08))));
    var pick = PickPart.newBuilder().setRobot("arm").setPart("part");
    scene.apply(ApplyRequest.newBuilder().addCommands(Command.newBuilder().setPickPart(pick)).build());
    awaitEnd(start(straightTo(pose(0.5, 0.0, 0.28))));
    System.out.printf("picked: the part is at %.2f m%n", height("part"));
    System.out.printf("measured: %.2f m%n", measured());

    Iterator<WatchCollisionsResponse> reports =
        collision.watchCollisions(WatchCollisionsRequest.getDefaultInstance());
    var report = reports.next(); // what touches now
    // Nobody watches the swing itself until it has touched something.
    Motion swing = start(toJoint("lbr_iiwa_joint_1", Math.PI / 2), DisconnectPolicy.DISCONNECT_POLICY_CONTINUE);
    while (report.getEventsCount() == 0 || !report.getEvents(0).hasBegun()) report = reports.next();
    var pair = report.getEvents(0).getBegun().getPair();
    var names = new TreeSet<String>();
    names.add(pair.getFirst());
    names.add(pair.getSecond());
    System.out.println("touching: " + String.join(" and ", names));
    awaitEnd(swing);

    try {
      start(toJoint("lbr_iiwa_jiont_4", 0.5));
    } catch (StatusRuntimeException refused) {
      var info = StatusProto.fromThrowable(refused).getDetails(0).unpack(ErrorInfo.class);
      System.out.println("refused: " + info.getReason() + ", nearest is " + info.getMetadataOrThrow("nearest"));
    }
  }

  public static void main(String[] arguments) throws Exception {
    if (arguments.length != 1) {
      System.err.println("give the scene file: Pick cell.yaml");
      System.exit(2);
    }
    Locale.setDefault(Locale.ROOT); // points in numbers, not commas
    String address = System.getenv().getOrDefault("VIRTUALROBOT_ADDRESS", "127.0.0.1:50500");
    String token = System.getenv().getOrDefault("VIRTUALROBOT_TOKEN", "");
    ManagedChannel channel = NettyChannelBuilder.forTarget(address).usePlaintext().build();
    try {
      new Pick(channel, token).work(Files.readString(Path.of(arguments[0])));
    } catch (StatusRuntimeException error) {
      System.err.println(error.getMessage());
      System.exit(1);
    } finally {
      channel.shutdownNow();
    }
  }
}
