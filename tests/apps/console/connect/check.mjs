// Calls of the kinds that Connect's own clients make of a console, by each protocol; prints what each is answered.
//
// Usage: node check.mjs http://127.0.0.1:8090 TOKEN

import { Code, ConnectError, createClient } from "@connectrpc/connect";
import { createConnectTransport, createGrpcWebTransport } from "@connectrpc/connect-node";
import { createConnectTransport as webConnect, createGrpcWebTransport as webGrpc } from "@connectrpc/connect-web";

import { ErrorInfoSchema } from "./generated/google/rpc/error_details_pb.js";
import { AssetService } from "./generated/virtualrobot/v1/asset_pb.js";
import { KernelService } from "./generated/virtualrobot/v1/kernel_pb.js";
import { RobotService } from "./generated/virtualrobot/v1/robot_pb.js";

const [baseUrl, token] = process.argv.slice(2);
const authorized = (next) => (request) => {
  request.header.set("authorization", `Bearer ${token}`);
  return next(request);
};
const options = { baseUrl, interceptors: [authorized] };
const node = { ...options, httpVersion: "1.1" };
const transports = {
  "connect-node": createConnectTransport({ ...node, useBinaryFormat: true }),
  "connect-node, JSON": createConnectTransport({ ...node, useBinaryFormat: false }),
  "grpc-web-node": createGrpcWebTransport({ ...node, useBinaryFormat: true }),
  "connect-web": webConnect({ ...options, useBinaryFormat: true }),
  "connect-web, JSON": webConnect(options),
  "grpc-web": webGrpc(options),
  "grpc-web, JSON": webGrpc({ ...options, useBinaryFormat: false }),
};

async function* pieces() {
  yield { sha256: "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", chunk: new TextEncoder().encode("a") };
  yield { chunk: new TextEncoder().encode("bc") };
}

for (const [name, transport] of Object.entries(transports)) {
  const kernel = createClient(KernelService, transport), robots = createClient(RobotService, transport);
  const { clock } = await kernel.getClock({});
  let watched = 0;
  const gone = new AbortController();
  try {
    for await (const { robots: states } of robots.watchRobotStates({}, { signal: gone.signal })) {
      watched = states.length;
      gone.abort(); // leaving the loop alone leaves the connection open
    }
  } catch (error) {
    if (ConnectError.from(error).code !== Code.Canceled) throw error;
  }
  let refused = "";
  try {
    await robots.getRobot({ name: "arn" });
  } catch (error) {
    const [info] = ConnectError.from(error).findDetails(ErrorInfoSchema);
    refused = `${ConnectError.from(error).code} ${info.reason} ${info.domain}`;
  }
  let late = "";
  try {
    for await (const _ of kernel.watchClock({}, { timeoutMs: 100 })) continue;
  } catch (error) {
    late = String(ConnectError.from(error).code);
  }
  let sent = "";
  if (name.includes("node")) {
    sent = String((await createClient(AssetService, transport).uploadAsset(pieces())).sizeBytes);
  }
  console.log([name, clock.mode, watched, refused, late, sent].join("; "));
}
