// What people say of a node: what it is for, tags, its icon; and its lock.
import { describe, setLocked } from "../kernel/orders";
import type { Item } from "../kernel/world";
import { ICONS } from "../parts/icons";
import { TextRow } from "../parts/text_row";

export function About({ item: { name, node } }: { item: Item }) {
  const { description, tags, icon, locked } = node;
  return (
    <section aria-label="About it">
      <div class="property">
        <span>Locked</span>
        <button type="button" role="switch" class="switch" aria-label="Locked" aria-checked={locked} title="Its name, parent, pose and figures stay as they are, and it can't be deleted"
          onClick={() => void setLocked(name, !locked)} />
      </div>
      <TextRow key={`description ${name} ${description}`} label="Description" value={description} write={(to) => void describe(name, { description: to })} />
      <TextRow key={`tags ${name} ${tags.join()}`} label="Tags" hint="Words by which it is found, with commas between them" value={tags.join(", ")} write={(to) => void describe(name, { tags: wordsIn(to) })} />
      <TextRow key={`icon ${name} ${icon}`} label="Icon" hint="That of its kind where there is none" value={icon} choices={ICONS} write={(to) => void describe(name, { icon: to })} />
    </section>
  );
}

function wordsIn(text: string): string[] {
  return [...new Set(text.split(",").map((word) => word.trim()).filter(Boolean))];
}
