// A choice of one of a few, side by side: arrows go from one to the next, and Enter takes it.
import { walkAcross } from "./arrows";

interface Props<T extends string> {
  label: string;
  /** What each is called, and what it is where that doesn't tell: with the unit. */
  options: readonly (readonly [T, string, string?])[];
  chosen: T | undefined;
  choose: (option: T) => void;
}

export function Choice<T extends string>({ label, options, chosen, choose }: Props<T>) {
  return (
    <span class="choice" role="radiogroup" aria-label={label} onKeyDown={walkAcross}>
      {options.map(([option, name, about]) => (
        <button key={option} type="button" role="radio" title={about ?? `${label}: ${name}`} aria-checked={option === chosen} onClick={() => choose(option)}>
          {name}
        </button>
      ))}
    </span>
  );
}
