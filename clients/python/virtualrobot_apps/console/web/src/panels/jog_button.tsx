// Buttons that move a robot while they are held, by pointer or by key.
import { goal } from "../kernel/goal";
import { letGo, press, type Move } from "../kernel/jog";
import { isGone } from "../kernel/world";
import { useHeld } from "../parts/held";
import { Icon } from "../parts/icons";

interface Props {
  label: string;
  icon: string;
}

export function JogButton({ label, icon, move }: Props & { move: () => Move }) {
  return <HoldButton label={label} icon={icon} begin={() => press(move())} end={letGo} />;
}

export function HoldButton({ label, icon, begin, end }: Props & { begin: () => void; end: () => void }) {
  const { held, listeners } = useHeld(() => {
    goal.clear();
    begin();
  }, end);
  return (
    <button type="button" class={`jog ${held && !isGone.value ? "held" : ""}`} aria-label={label} title={`${label}: moves while it is held`} {...listeners}>
      <Icon name={icon} size={14} />
    </button>
  );
}
