// What asks the kernel for something: it is disabled while the kernel is gone or lets nobody in.
import type { ComponentChildren } from "preact";
import { isGone } from "../kernel/world";

export function WhileConnected({ children }: { children: ComponentChildren }) {
  return <fieldset class="asks" disabled={isGone.value}>{children}</fieldset>;
}
