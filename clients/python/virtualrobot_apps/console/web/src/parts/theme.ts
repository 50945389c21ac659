// Dark or light, as this browser was left, or else as its system is.
import { effect, signal } from "@preact/signals";

export type Theme = "dark" | "light";

const KEY = "virtualrobot-theme";
const LIGHT = matchMedia("(prefers-color-scheme: light)");

const stored = (): Theme | undefined => {
  const kept = localStorage.getItem(KEY);
  return kept === "light" || kept === "dark" ? kept : undefined;
};
const wanted = (): Theme => stored() ?? (LIGHT.matches ? "light" : "dark");

export const theme = signal<Theme>(wanted());

export function switchTheme(): void {
  theme.value = theme.value === "dark" ? "light" : "dark";
  localStorage.setItem(KEY, theme.value);
}

LIGHT.addEventListener("change", () => (theme.value = wanted()));

effect(() => {
  document.documentElement.dataset.theme = theme.value;
});
