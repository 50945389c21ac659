// A question over the view, with its answers as buttons; Esc answers none of them.
import { useEffect, useRef } from "preact/hooks";
import { asked } from "../kernel/question";

export function Question() {
  const question = asked.value;
  const first = useRef<HTMLButtonElement>(null);
  useEffect(() => first.current?.focus(), [question]);
  if (!question) return null;
  return (
    <div class="veil" onKeyDown={(event) => event.key === "Escape" && (event.stopPropagation(), question.answer(undefined))}>
      <div class="float question" role="dialog" aria-label={question.title}>
        <h2>{question.title}</h2>
        <p class="muted words">{question.text}</p>
        <div class="answers">
          {question.answers.map(([answer, name], place) => (
            <button key={answer} ref={place === 0 ? first : undefined} type="button" class={`button ${place === 0 ? "primary" : ""}`} onClick={() => question.answer(answer)}>
              <span class="cut">{name}</span>
            </button>
          ))}
          <button type="button" class="button" onClick={() => question.answer(undefined)}>Cancel</button>
        </div>
      </div>
    </div>
  );
}
