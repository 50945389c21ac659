import { defineConfig } from "vite";

// The player of recorded runs: one file, which the client library writes into a page with the run.
export default defineConfig({
  build: {
    target: "es2022",
    outDir: "../../../virtualrobot/recording/player",
    emptyOutDir: true,
    chunkSizeWarningLimit: 2000,
    rollupOptions: {
      input: "src/player/player.ts",
      output: { format: "es", entryFileNames: "player.js", codeSplitting: false },
    },
  },
});
