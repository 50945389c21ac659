// What asks the kernel for something: it is disabled while the kernel is gone.
import type { ComponentChildren } from "preact";
import { connection } from "../kernel/world";

export function WhileConnected({ children }: { children: ComponentChildren }) {
  return <fieldset class="asks" disabled={connection.value === "lost"}>{children}</fieldset>;
}
