// A question to the person at the page, one at a time; the cell stays in sight, and STOP in reach.
import { signal } from "@preact/signals";

export interface Question {
  title: string;
  text: string;
  /** What may be answered, and what the answer is called; the first one is what most people want. */
  answers: readonly (readonly [answer: string, name: string])[];
}

interface Asked extends Question {
  answer: (answer: string | undefined) => void;
}

export const asked = signal<Asked | undefined>(undefined);

/** Asks, and returns the answer; undefined when the person wants none of them. */
export function ask(question: Question): Promise<string | undefined> {
  asked.peek()?.answer(undefined);
  return new Promise((resolve) => {
    const answer = (one: string | undefined) => {
      asked.value = undefined;
      resolve(one);
    };
    asked.value = { ...question, answer };
  });
}
