// What stands in place of a robot's panel while there is none, or while the kernel hasn't told of it yet.
import { chosen, connection } from "../kernel/world";

export function NoRobot() {
  const words = chosen.value ? `The kernel is asked about ${chosen.value} …` : "There is no robot here yet. The library has some.";
  return <div class="body">{connection.value === "connected" && <p class="hint" role="status">{words}</p>}</div>;
}
