// A button that moves a robot while it is held, by pointer or by key.
import { useState } from "preact/hooks";
import { goal } from "../kernel/goal";
import { letGo, press, type Move } from "../kernel/jog";
import { Icon } from "../parts/icons";

interface Props {
  label: string;
  icon: string;
  move: () => Move;
}

export function JogButton({ label, icon, move }: Props) {
  const [held, setHeld] = useState(false);
  const begin = () => {
    goal.clear();
    setHeld(true);
    press(move());
  };
  const end = () => {
    if (held) letGo();
    setHeld(false);
  };
  return (
    <button type="button" class={`jog ${held ? "held" : ""}`} aria-label={label} title={`${label}: moves while it is held`}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        begin();
      }}
      onPointerUp={end} onLostPointerCapture={end} onBlur={end} onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => event.key === "Enter" && !event.repeat && begin()}
      onKeyUp={(event) => event.key === "Enter" && end()}>
      <Icon name={icon} size={14} />
    </button>
  );
}
