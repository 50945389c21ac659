// The program as a text, in a controller's own language. The editor is loaded when somebody opens it first.
import type { ComponentType } from "preact";
import { useEffect, useState } from "preact/hooks";

export function Code() {
  const [Panel, setPanel] = useState<ComponentType>();
  const [fault, setFault] = useState("");
  useEffect(() => {
    import("../code/panel").then(({ CodePanel }) => setPanel(() => CodePanel), () => setFault("the editor can't be loaded; load the page again"));
  }, []);
  if (Panel) return <Panel />;
  return <p class={fault ? "hint warned" : "hint"}>{fault || "The editor is loaded …"}</p>;
}
