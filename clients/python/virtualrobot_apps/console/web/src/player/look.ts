// The player's look, within its one file.
export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];

export const LOOK = `
  :root { color-scheme: light dark; --panel: light-dark(#fbfcfdee, #15191fee); --line: light-dark(#d5dce4, #29313b);
    --text: light-dark(#17202a, #e4e9ef); --accent: light-dark(#0b72e0, #3b9eff); }
  html, body { margin: 0; height: 100%; overflow: hidden; font: 13px system-ui, sans-serif; color: var(--text); }
  canvas { display: block; outline: none; }
  .bar { position: fixed; left: 16px; right: 16px; bottom: 16px; display: flex; gap: 12px; align-items: center;
    padding: 8px 12px; border: 1px solid var(--line); border-radius: 10px; background: var(--panel);
    backdrop-filter: blur(8px); }
  .bar input { flex: 1; min-width: 80px; accent-color: var(--accent); }
  .bar output { font-variant-numeric: tabular-nums; white-space: nowrap; }
  button, select { min-width: 32px; height: 28px; border: 1px solid var(--line); border-radius: 7px;
    background: transparent; color: inherit; font: inherit; cursor: pointer; }
  button:focus-visible, select:focus-visible, input:focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
  .name { position: fixed; top: 0; left: 0; padding: 2px 7px; border-radius: 6px; background: var(--panel);
    pointer-events: none; }
  .name:empty { display: none; }
`;
