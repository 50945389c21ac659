// Buttons that move a robot while they are held, by pointer or by key.
import { useState } from "preact/hooks";
import { goal } from "../kernel/goal";
import { letGo, press, type Move } from "../kernel/jog";
import { connection } from "../kernel/world";
import { Icon } from "../parts/icons";

interface Props {
  label: string;
  icon: string;
}

export function JogButton({ label, icon, move }: Props & { move: () => Move }) {
  return <HoldButton label={label} icon={icon} begin={() => press(move())} end={letGo} />;
}

export function HoldButton({ label, icon, begin, end }: Props & { begin: () => void; end: () => void }) {
  const [held, setHeld] = useState(false);
  const down = () => {
    goal.clear();
    setHeld(true);
    begin();
  };
  const up = () => {
    if (held) end();
    setHeld(false);
  };
  return (
    <button type="button" class={`jog ${held && connection.value !== "lost" ? "held" : ""}`} aria-label={label} title={`${label}: moves while it is held`}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        down();
      }}
      onPointerUp={up} onLostPointerCapture={up} onBlur={up} onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => event.key === "Enter" && !event.repeat && down()}
      onKeyUp={(event) => event.key === "Enter" && up()}>
      <Icon name={icon} size={14} />
    </button>
  );
}
