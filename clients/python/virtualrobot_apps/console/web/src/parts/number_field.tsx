// A number that is shown, and can be written where `write` takes it.
import { useEffect, useRef, useState } from "preact/hooks";
import { chosen, selected } from "../kernel/world";
import { fixed, read, whyNot } from "./numbers";
import { tellNumber } from "./wrong_number";

interface Props {
  /** What it is called: with `name` in it where that is seen. */
  label: string;
  /** What it is, where the label doesn't tell. */
  about?: string;
  name?: string;
  value: number;
  unit: string;
  decimals: number;
  color?: string;
  write?: (value: number) => void;
}

export function NumberField({ label, about = label, name, value, unit, decimals, color, write }: Props) {
  const [text, setText] = useState<string | undefined>(undefined);
  const field = useRef<HTMLInputElement>(null);
  /** The text as it was found: leaving the field by Tab takes what was changed. */
  const found = useRef("");
  const why = text === undefined ? "" : whyNot(text);
  const drop = (of: HTMLInputElement) => {
    setText(undefined);
    tellNumber(of, "");
  };
  // What is wrong stays until it is mended, or the field is another one's.
  useEffect(() => drop.bind(undefined, field.current!), [selected.value, chosen.value]);
  const take = (said: string) => {
    const written = read(said);
    if (written === undefined) return;
    write?.(written);
    setText(undefined);
  };
  return (
    <label class={`field ${why ? "wrong" : ""}`} title={why || `${about}${unit ? `, ${unit}` : ""}`}>
      {name && <b style={{ color }}>{name}</b>}
      <input ref={field} class="mono" aria-label={label} aria-invalid={why !== ""} readOnly={!write} inputMode="decimal" value={text ?? fixed(value, decimals)}
        onFocus={(event) => {
          if (!write) return;
          if (!why) setText((found.current = fixed(value, decimals)));
          event.currentTarget.select();
        }}
        onInput={(event) => {
          if (!write) return;
          setText(event.currentTarget.value);
          tellNumber(event.currentTarget);
        }}
        onBlur={() => setText((now) => (now !== undefined && whyNot(now) ? now : undefined))}
        onKeyDown={(event) => {
          const said = event.currentTarget.value;
          if (write && (event.key === "Enter" || event.key === "Tab")) tellNumber(event.currentTarget);
          if (event.key === "Enter" && text !== undefined) take(said);
          if (event.key === "Tab" && write && said !== found.current) take(said);
          if (event.key === "Escape") drop(event.currentTarget);
          if (event.key === "Escape" || (event.key === "Enter" && !whyNot(said))) event.currentTarget.blur();
        }} />
      <i>{unit}</i>
    </label>
  );
}
