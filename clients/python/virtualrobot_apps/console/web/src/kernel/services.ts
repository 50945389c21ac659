// The services of the contract that this page calls.
import { createClient } from "@connectrpc/connect";
import { AssetService } from "../generated/virtualrobot/v1/asset_pb";
import { CollisionService } from "../generated/virtualrobot/v1/collision_pb";
import { DriverService } from "../generated/virtualrobot/v1/driver_pb";
import { HistoryService } from "../generated/virtualrobot/v1/history_pb";
import { KernelService } from "../generated/virtualrobot/v1/kernel_pb";
import { LeaseService } from "../generated/virtualrobot/v1/lease_pb";
import { MotionService } from "../generated/virtualrobot/v1/motion_pb";
import { ProposalService } from "../generated/virtualrobot/v1/proposal_pb";
import { RecordService } from "../generated/virtualrobot/v1/record_pb";
import { RobotService } from "../generated/virtualrobot/v1/robot_pb";
import { SceneService } from "../generated/virtualrobot/v1/scene_pb";
import { SensorService } from "../generated/virtualrobot/v1/sensor_pb";
import { SignalService } from "../generated/virtualrobot/v1/signal_pb";
import { ViewService } from "../generated/virtualrobot/v1/view_pb";
import { PageCalls } from "./page_calls";

export const calls = new PageCalls(`${location.origin.replace(/^http/, "ws")}/calls`, { "client-name": "console" });

export const assets = createClient(AssetService, calls);
export const collisions = createClient(CollisionService, calls);
export const drivers = createClient(DriverService, calls);
export const history = createClient(HistoryService, calls);
export const kernel = createClient(KernelService, calls);
export const leases = createClient(LeaseService, calls);
export const motions = createClient(MotionService, calls);
export const proposals = createClient(ProposalService, calls);
export const records = createClient(RecordService, calls);
export const robots = createClient(RobotService, calls);
export const scenes = createClient(SceneService, calls);
export const sensors = createClient(SensorService, calls);
export const signals = createClient(SignalService, calls);
export const views = createClient(ViewService, calls);
