// Tabs on top of a panel.
import type { ComponentType } from "preact";
import { walkAcross } from "./arrows";
import { Icon } from "./icons";

export interface Tab {
  id: string;
  icon: string;
  name: string;
  count?: number;
  alarm?: boolean;
  /** What is below the tab when it is chosen. */
  panel: ComponentType;
}

interface Props {
  label: string;
  tabs: readonly Tab[];
  chosen: string;
  choose: (id: string) => void;
}

/** Shows the panel of the chosen tab. */
export function Chosen({ tabs, chosen }: Pick<Props, "tabs" | "chosen">) {
  const Panel = tabs.find(({ id }) => id === chosen)?.panel;
  return Panel ? <Panel /> : null;
}

/** Brings a tab into its bar, which scrolls where it is narrow; the page stays where it is. */
function intoView(tab: HTMLElement | null): void {
  const bar = tab?.parentElement;
  if (!tab || !bar) return;
  if (tab.offsetLeft < bar.scrollLeft) bar.scrollLeft = tab.offsetLeft;
  else if (tab.offsetLeft + tab.offsetWidth > bar.scrollLeft + bar.clientWidth) bar.scrollLeft = tab.offsetLeft + tab.offsetWidth - bar.clientWidth;
}

export function Tabs({ label, tabs, chosen, choose }: Props) {
  return (
    <div class="tabs" role="tablist" aria-label={label} onKeyDown={(event) => walkAcross(event)?.click()}>
      {tabs.map(({ id, icon, name, count, alarm }) => (
        <button key={id} ref={chosen === id ? intoView : undefined} type="button" role="tab" tabIndex={chosen === id ? 0 : -1} aria-selected={chosen === id} class="tab" title={name} onClick={() => choose(id)}>
          <Icon name={icon} size={14} />
          {name}
          {!!count && <span class={alarm ? "badge alarm" : "badge"}>{count}</span>}
        </button>
      ))}
    </div>
  );
}
