// A code for a phone or a headset, which lets its browser in once, for what this page may.
import { signal } from "@preact/signals";
import { askConsole } from "../kernel/console_calls";
import { attempt } from "../kernel/messages";
import { Icon } from "../parts/icons";

/** A link and its code, SVG; those of the authority that devices trust once; or why other devices don't get here. */
interface Invited {
  url?: string;
  code?: string;
  trust?: string;
  trust_code?: string;
  fault?: string;
}

const invited = signal<Invited | undefined>(undefined);

export function Invitation() {
  const now = invited.value;
  return (
    <>
      <button type="button" class="button" title="A code that lets one browser in, for what this page may" onClick={() => void ask()}>
        <Icon name="qr-code" size={14} />{now?.code ? "Another code" : "Code for a phone or headset"}
      </button>
      {now?.fault && <p class="hint">{now.fault}.</p>}
      {now?.trust && <Code svg={now.trust_code!} url={now.trust} name="Once on each device: trust this installation" />}
      {now?.url && <Code svg={now.code!} url={now.url} name="Then, good once: this page" />}
      {now?.url && <button type="button" class="button small" onClick={() => (invited.value = undefined)}>Hide the codes</button>}
    </>
  );
}

function Code({ svg, url, name }: { svg: string; url: string; name: string }) {
  return (
    <figure class="invitation">
      <img alt={`Code of ${url.replace(/key=.*/, "key=…")}`} src={`data:image/svg+xml,${encodeURIComponent(svg)}`} />
      <figcaption>{name}</figcaption>
    </figure>
  );
}

async function ask(): Promise<void> {
  invited.value = await attempt(askConsole<Invited>("/invitation", {}));
}
