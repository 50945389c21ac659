// A number that is shown, and can be written where `write` takes it.
import { useRef, useState } from "preact/hooks";
import { fixed, read } from "./numbers";

interface Props {
  label: string;
  name?: string;
  value: number;
  unit: string;
  decimals: number;
  color?: string;
  write?: (value: number) => void;
}

export function NumberField({ label, name, value, unit, decimals, color, write }: Props) {
  const [text, setText] = useState<string | undefined>(undefined);
  /** The text as it was found: leaving the field by Tab takes what was changed. */
  const found = useRef("");
  const wrong = text !== undefined && read(text) === undefined;
  const take = (said: string) => {
    const written = read(said);
    if (written !== undefined && write) write(written);
    setText(undefined);
  };
  return (
    <label class={`field ${wrong ? "wrong" : ""}`} title={`${label}${unit ? `, ${unit}` : ""}`}>
      {name && <b style={{ color }}>{name}</b>}
      <input class="mono" aria-label={label} readOnly={!write} inputMode="decimal" value={text ?? fixed(value, decimals)}
        onFocus={(event) => write && (setText((found.current = fixed(value, decimals))), event.currentTarget.select())}
        onInput={(event) => write && setText(event.currentTarget.value)}
        onBlur={() => setText(undefined)}
        onKeyDown={(event) => {
          if (event.key === "Enter") (text !== undefined && take(event.currentTarget.value), event.currentTarget.blur());
          if (event.key === "Tab" && write && event.currentTarget.value !== found.current) take(event.currentTarget.value);
          if (event.key === "Escape") event.currentTarget.blur();
        }} />
      <i>{unit}</i>
    </label>
  );
}
