// A row of a panel with a text, written when Enter is pressed.
import { useId } from "preact/hooks";

interface TextProps {
  label: string;
  value: string;
  hint?: string;
  /** Texts that are offered. */
  choices?: readonly string[];
  /** Without it the text is only read. */
  write?: (text: string) => void;
}

export function TextRow({ label, value, hint, choices, write }: TextProps) {
  const list = useId();
  return (
    <label class="property" title={hint}>
      <span>{label}</span>
      <input class="text" aria-label={label} readOnly={!write} defaultValue={value} list={choices && list}
        onBlur={(event) => (event.currentTarget.value = value)}
        onKeyDown={(event) => {
          if (event.key === "Enter" && event.currentTarget.value !== value) write?.(event.currentTarget.value.trim());
          if (event.key === "Enter" || event.key === "Escape") event.currentTarget.blur();
        }} />
      {choices && <datalist id={list}>{choices.map((one) => <option key={one} value={one} />)}</datalist>}
    </label>
  );
}
