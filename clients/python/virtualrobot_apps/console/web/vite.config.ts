import { defineConfig } from "vite";

export default defineConfig({
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
  build: {
    target: "es2022",
    outDir: "../page/app",
    emptyOutDir: true,
    // What is inlined as a `data:` address is refused by the page's own policy.
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 2000,
  },
  // While it is written: `virtualrobot console --origin http://localhost:5173`, and the page's calls go there.
  server: { proxy: { "/calls": { target: "ws://127.0.0.1:8090", ws: true } } },
});
