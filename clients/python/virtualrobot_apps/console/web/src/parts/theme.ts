// Dark or light, as this browser was left, or else as its system is.
import { effect, signal } from "@preact/signals";

export type Theme = "dark" | "light";

const KEY = "virtualrobot-theme";
const stored = localStorage.getItem(KEY);

export const theme = signal<Theme>(stored === "light" || stored === "dark" ? stored : "dark");

export function switchTheme(): void {
  theme.value = theme.value === "dark" ? "light" : "dark";
  localStorage.setItem(KEY, theme.value);
}

effect(() => {
  document.documentElement.dataset.theme = theme.value;
});
