import { Calls } from "/calls.js";

const calls = new Calls("/calls", { "client-name": "console" });
const at = (id) => document.getElementById(id);
const rounded = (values) => values.map((value) => value.toFixed(3)).join("  ");
const tell = (words) => (at("kernel").textContent = words);

at("curl").textContent =
  `curl ${location.origin}/virtualrobot.v1.RobotService/GetRobotStates \\\n` +
  `  -H "Authorization: Bearer $VIRTUALROBOT_TOKEN" --json '{}'`;

function stop() {
  calls.ask("MotionService/Stop").then(() => tell("stopped"), (refused) => tell(refused.message));
}
at("stop").onclick = stop;
addEventListener("keydown", (event) => {
  if (event.code === "Space" && !event.repeat) {
    event.preventDefault();
    stop();
  }
});

const rows = new Map();
function show({ robots, removed_names }) {
  for (const name of removed_names) {
    rows.get(name)?.remove();
    rows.delete(name);
  }
  for (const { name, positions, world_t_tcp } of robots) {
    let row = rows.get(name);
    if (row === undefined) {
      row = at("robots").tBodies[0].insertRow();
      for (let cell = 0; cell < 3; cell++) row.insertCell();
      row.cells[0].textContent = name;
      rows.set(name, row);
    }
    const place = world_t_tcp?.position;
    row.cells[1].textContent = rounded(positions);
    row.cells[2].textContent = place ? rounded([place.x, place.y, place.z]) : "";
  }
}

try {
  const info = await calls.ask("KernelService/GetInfo");
  tell(`kernel ${info.version}${info.role ? ", " + info.role.replace("ROLE_", "").toLowerCase() : ""}`);
  if (info.viewer_url) {
    const link = document.createElement("a");
    link.href = info.viewer_url;
    link.textContent = "The cell in 3D, on the kernel's machine";
    at("viewer").append(link);
  }
  const onEnd = (refused) => tell(refused ? refused.message : "the watch has ended");
  calls.open("RobotService/WatchRobotStates", { onAnswer: show, onEnd }).send({});
} catch (refused) {
  tell(refused.message);
}
