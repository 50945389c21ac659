// Programs of robots' languages at work, whoever runs them: where they are, what they write and ask; stopped and answered here.
import type { Record as Told } from "../generated/virtualrobot/v1/record_pb";
import { fileWish } from "../kernel/tasks";
import { personOf } from "../kernel/words";
import { tasks } from "../kernel/world";
import { Icon } from "../parts/icons";

/** What a task's record holds, as far as it is shown. */
interface Content {
  language?: string;
  robot?: string;
  program_pointer?: string;
  lines?: string[];
  question?: string;
  choices?: string[];
}

export function Tasks() {
  const atWork = [...tasks.value.values()].filter(({ isOver }) => !isOver);
  if (atWork.length === 0) return null;
  return (
    <div role="list" aria-label="Programs at work">
      {atWork.map((one) => <Row key={one.id} one={one} />)}
    </div>
  );
}

function Row({ one }: { one: Told }) {
  const { language = "", robot = "", program_pointer: pointer = "", lines = [], question = "", choices = [] } = contentOf(one);
  const answer = (text: string) => fileWish(one.id, "answer", text);
  return (
    <div class="entry" role="listitem" aria-label={`Program ${one.title}`}>
      <Icon name="code" size={14} color="var(--accent)" />
      <b class="what cut" title={`${language} of ${one.author}`}>{one.title}</b>
      <span class="muted cut">{robot || personOf(one.author)}</span>
      <span class="mono cut" title={pointer}>{pointer.split("/").at(-1)}</span>
      <span class="muted grow cut">{question || lines.at(-1)}</span>
      {question && choices.map((each) => <button key={each} type="button" class="button small" onClick={() => answer(each)}>{each}</button>)}
      {question && choices.length === 0 && (
        <input class="small" aria-label={`Answer ${one.title}`} placeholder="answer, then Enter" onKeyDown={(event) => event.key === "Enter" && answer(event.currentTarget.value)} />
      )}
      <button type="button" class="button small" disabled={!one.isHeld} title="Before its next statement; its robot brakes on its path" onClick={() => fileWish(one.id, "stop")}><Icon name="square" size={13} />Stop {one.title}</button>
    </div>
  );
}

/** What a record's content says; a client may write anything there. */
function contentOf(one: Told): Content {
  try {
    const said: unknown = JSON.parse(one.content);
    return typeof said === "object" && said !== null ? said : {};
  } catch {
    return {};
  }
}
