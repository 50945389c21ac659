// The name of a node, written or chosen from those that there are.
import { useId, useState } from "preact/hooks";
import { items } from "../kernel/world";

interface Props {
  label: string;
  name?: string;
  value: string;
  placeholder?: string;
  choose: (name: string) => void;
}

export function NodeField({ label, name, value, placeholder, choose }: Props) {
  const list = useId();
  const [text, setText] = useState<string | undefined>(undefined);
  return (
    <label class="field node-field" title={label}>
      {name && <b>{name}</b>}
      <input aria-label={label} list={list} value={text ?? value} placeholder={placeholder}
        onInput={(event) => setText(event.currentTarget.value)}
        onBlur={() => setText(undefined)}
        onChange={(event) => (choose(event.currentTarget.value.trim()), setText(undefined))} />
      <datalist id={list}>
        {[...items.value.values()].map((one) => <option key={one.uid} value={one.name} />)}
      </datalist>
    </label>
  );
}
