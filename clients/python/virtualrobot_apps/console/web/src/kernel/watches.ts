// The watches by which this page knows the world; one that ends is begun again.
import { Code, ConnectError } from "@connectrpc/connect";
import { StepKind } from "../generated/virtualrobot/v1/history_pb";
import { ClockMode } from "../generated/virtualrobot/v1/kernel_pb";
import { MotionPhase } from "../generated/virtualrobot/v1/motion_pb";
import type { WatchSceneResponse } from "../generated/virtualrobot/v1/scene_pb";
import { ofArray } from "./arrays";
import { takeCoats } from "./coats";
import { take as takeCollisions } from "./collisions";
import { attempt, say } from "./messages";
import { compare } from "./served_page";
import * as service from "./services";
import { picture } from "./shared_picture";
import { heads, viewers } from "./viewers";
import { forPeople, wordsOf } from "./words";
import * as world from "./world";
import { isSmall } from "../xr/support";

const GIVEN_RATE = new URLSearchParams(location.search).get("rate");
/** How often poses come to a page, and to one that can enter a room, where each picture is near the eyes. */
const RATE_HERTZ = 30, ROOM_HERTZ = 60;
const AGAIN_MS = 700;
const MOTIONS_HERTZ = 4;
const ENDED: ReadonlySet<MotionPhase> = new Set([MotionPhase.SUCCEEDED, MotionPhase.CANCELLED, MotionPhase.ABORTED]);
const MOST_STEPS = 60;

let epoch = 0n;

/** Begins all watches; they go on for ever. */
export async function watch(): Promise<void> {
  const maxRateHertz = Number(GIVEN_RATE ?? ((await isSmall()) ? ROOM_HERTZ : RATE_HERTZ));
  void follow(() => service.scenes.watchScene({ maxRateHertz }), takeScene);
  void follow(
    () => service.robots.watchRobotStates({ maxRateHertz }),
    (said, first) => {
      const next = new Map(first ? [] : world.states.value);
      for (const state of said.robots) next.set(state.name, state);
      for (const name of said.removedNames) next.delete(name);
      world.states.value = next;
      for (const hear of world.hearers.states) hear(said.stamp?.simulationTimeSeconds ?? 0);
    },
  );
  void follow(
    () => service.kernel.watchClock({ maxRateHertz: 4 }),
    (said) => {
      world.simulationTime.value = said.stamp?.simulationTimeSeconds ?? 0;
      world.clock.value = said.clock;
    },
  );
  void follow(
    () => service.signals.watchSignals({}),
    (said, first) => {
      const next = new Map(first ? [] : world.cellSignals.value);
      for (const one of said.signals) next.set(one.name, one);
      for (const name of said.removedNames) next.delete(name);
      const gone = first ? [...world.cellSignals.peek().keys()].filter((name) => !next.has(name)) : said.removedNames;
      world.cellSignals.value = next;
      for (const hear of world.hearers.signals) hear({ signals: said.signals, removed: gone, time: said.stamp?.simulationTimeSeconds ?? 0 });
    },
  );
  void follow(() => service.collisions.watchCollisions({}), takeCollisions);
  void follow(
    () => service.proposals.watchProposals({}),
    (said, first) => {
      const next = new Map(first ? [] : world.proposals.value);
      for (const one of said.proposals) next.set(one.id, one);
      for (const id of said.removedIds) next.delete(id);
      world.proposals.value = next;
    },
  );
  void follow(
    () => service.records.watchRecords({ kinds: ["task"] }),
    (said, first) => {
      const next = new Map(first ? [] : world.tasks.value);
      for (const one of said.records) next.set(one.id, one);
      for (const id of said.removedIds) next.delete(id);
      world.tasks.value = next;
    },
  );
  void follow(
    () => service.drivers.watchDrivers({ maxRateHertz: 10 }),
    (said) => {
      world.drivers.value = said.drivers;
      world.cell.value = said.cell;
    },
  );
  void follow(
    () => service.motions.watchMotions({ maxRateHertz: MOTIONS_HERTZ }),
    (said) => {
      world.motions.value = said.motions.filter(({ phase }) => !ENDED.has(phase));
      world.speedFactor.value = said.speedFactor;
    },
  );
  void follow(() => service.views.watchView({}), (said) => void (picture.value = said.view));
  void follow(() => service.views.watchCoats({}), takeCoats);
  void follow(() => service.views.meetViewers(heads()), (said) => void (viewers.value = said.viewers));
  void follow(() => service.leases.watchLeases({}), (said) => void (world.leases.value = said.leases));
  void followSteps();
}

/** Begins a watch again and again, and takes what it tells; `first` says that all is told anew. */
async function follow<T>(begin: () => AsyncIterable<T>, take: (said: T, first: boolean) => void | Promise<void>): Promise<never> {
  for (;;) {
    let first = true;
    try {
      for await (const said of begin()) {
        await take(said, first);
        if (first) told();
        first = false;
      }
    } catch (error) {
      lost(ConnectError.from(error));
    }
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
}

function told(): void {
  if (world.connection.value === "connected") return;
  if (world.connection.value === "lost") {
    say("connected again", "good");
    void compare();
  }
  world.connection.value = "connected";
  world.trouble.value = "";
  void service.kernel.getInfo({}).then((said) => (world.info.value = said), () => {});
}

function lost(error: ConnectError): void {
  const refused = error.code === Code.Unauthenticated || error.code === Code.PermissionDenied;
  if (!refused && error.code !== Code.Unavailable) {
    if (error.code !== Code.Canceled) say(forPeople(error.rawMessage), "error");
    return;
  }
  if (world.connection.value === "connected") say(forPeople(error.rawMessage), "error");
  world.connection.value = refused ? "refused" : "lost";
  world.trouble.value = error.rawMessage;
}

function takeScene(said: WatchSceneResponse): void {
  if (said.stamp && said.stamp.epoch !== epoch) {
    epoch = said.stamp.epoch;
    forget();
  }
  // Who was too slow is told everything anew, the world's own node first.
  const whole = said.nodes.some((node) => node.kind.case === "world");
  if (said.nodes.length > 0 || said.removedUids.length > 0) takeNodes(said, whole);
  if (said.worldTNode) {
    const rows = ofArray(said.worldTNode);
    for (const hear of world.hearers.poses) hear(said.movedUids, rows);
    world.moves.value++;
  }
  if (said.stamp) world.simulationTime.value = said.stamp.simulationTimeSeconds;
}

function takeNodes(said: WatchSceneResponse, whole: boolean): void {
  const next = new Map(whole ? [] : world.items.value);
  if (whole) world.names.clear();
  const renamed = new Map<string, string>();
  for (const uid of said.removedUids) {
    next.delete(world.names.get(uid) ?? "");
    world.names.delete(uid);
  }
  for (const { uid, name } of said.nodes) {
    const before = world.names.get(uid);
    world.names.set(uid, name);
    if (before === undefined || before === name) continue;
    renamed.set(before, name);
    next.delete(before);
  }
  // Only then: a name may have gone from one node to another.
  for (const node of said.nodes) {
    const kind = node.kind.case ?? "object";
    const parent = kind === "world" ? "" : node.parent || "world";
    next.set(node.name, { uid: node.uid, name: node.name, parent, hidden: node.hidden, kind, node });
  }
  world.items.value = next;
  for (const name of [world.selected, world.chosen]) {
    name.value = renamed.get(name.value) ?? (next.has(name.value) ? name.value : "");
  }
  const changed = new Set(said.nodes.map(({ name }) => world.robotOf(name)));
  const known = new Map([...world.robots.value].filter(([name]) => next.get(name)?.kind === "robot"));
  world.robots.value = known;
  for (const name of changed) if (name) void describe(name);
  if (!world.chosen.value) world.chosen.value = world.robotNames.value[0] ?? "";
  for (const hear of world.hearers.structure) hear(renamed);
}

async function describe(name: string): Promise<void> {
  try {
    const said = await service.robots.getRobot({ name });
    world.robots.value = new Map(world.robots.value).set(name, said);
  } catch (error) {
    // One that is gone again is told by the scene.
    if (world.items.peek().has(name)) say(`${name}: ${wordsOf(error)}`, "error");
  }
}

/** Forgets the nodes of another world: of a kernel before this one, or before a scene was loaded. The root stays, and isn't told again. */
function forget(): void {
  const root = world.items.peek().get("world");
  world.names.clear();
  if (root) world.names.set(root.uid, root.name);
  world.items.value = new Map(root ? [[root.name, root]] : []);
  world.robots.value = new Map();
}

async function followSteps(): Promise<never> {
  return follow(
    async function* () {
      const { steps } = await service.history.listSteps({ pageSize: MOST_STEPS });
      world.steps.value = steps;
      yield* service.history.watchSteps({});
    },
    async (said) => {
      // What is taken back changes steps that were told before.
      if (said.steps.some(({ kind }) => kind === StepKind.UNDO || kind === StepKind.REDO || kind === StepKind.RESTORE)) {
        world.steps.value = (await service.history.listSteps({ pageSize: MOST_STEPS })).steps;
        return;
      }
      const replaced = (number: bigint) => said.steps.some((step) => step.firstNumber <= number && number <= step.number);
      const kept = world.steps.value.filter(({ number }) => !replaced(number));
      world.steps.value = [...said.steps.toReversed(), ...kept].slice(0, MOST_STEPS);
    },
  );
}

/** Lets time stand still, or go on. */
export async function holdTime(): Promise<void> {
  const stepped = world.clock.value?.mode === ClockMode.STEPPED;
  await attempt(service.kernel.setClock({ mode: stepped ? ClockMode.REALTIME : ClockMode.STEPPED }));
}
