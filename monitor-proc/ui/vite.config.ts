import { defineConfig } from "vite";

// The page is served by the monitor from its own origin: no path outside of it.
export default defineConfig({
  base: "./",
  build: {
    outDir: "dist",
    target: "es2022",
    chunkSizeWarningLimit: 1500,
    // A copy of the page must carry the notices of the packages in it.
    license: { fileName: "licences.md" },
  },
});
